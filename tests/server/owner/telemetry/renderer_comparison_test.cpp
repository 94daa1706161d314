#include "server/owner/telemetry/renderer_comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "tests/server/support/device_rig.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/pressing_hand.hpp"

namespace haptic::server {
namespace {

constexpr double kStiffness = 1500.0, kForceLimit = 1e3;

core::RenderSettings equal_settings(int n_a) {
  return {.stiffness = core::VecA::Constant(n_a, kStiffness),
          .force_limit = core::VecA::Constant(n_a, kForceLimit)};
}

/// Some equal fingers, bent to 30 and 30 deg, each with its own comparison.
struct ComparedHand {
  explicit ComparedHand(int count) : kinematics(equal_fingers(count)), comparison(kinematics) {
    record.input.settings = equal_settings(count);
    record.anchor.x_probe = core::VecX::Constant(2 * count, 30 * kDegree);
    EXPECT_EQ(kinematics->inverse(record.anchor.x_probe, record.sensed.q),
              core::InverseStatus::kExact);
    record.anchor.x = record.anchor.x_probe;
    record.anchor.projection = core::ProjectionStatus::kExact;
    record.life.gain = 1.0;
  }
  /// A stop holds the first finger's first joint back.
  void press() { record.anchor.x[0] -= 0.05; }

  std::shared_ptr<const core::Kinematics> kinematics;
  RendererComparison comparison;
  core::TickRecord record{};
};

/// The rig's map is the identity, so nothing couples the DoFs: all four methods render the same
/// spring. It has 100 N/m and gives at most 10 N times the gain. The probe is at 0.
TEST(RendererComparison, AllAgreeOnTheIdentityMap) {
  const core::PipelineConfig rig = test::rig_config();
  RendererComparison comparison(rig.kinematics);
  core::TickRecord record;
  record.input.settings = rig.scene;
  record.sensed.q = core::VecQ::Zero(2);
  record.anchor.x = core::VecX::Zero(2);
  const auto expect_force = [&](double tau_a) {
    for (const core::VecA& tau : comparison.evaluate(record)) EXPECT_NEAR(tau[0], tau_a, 1e-12);
  };
  const struct {
    const char* what;
    double gain, x, stiffness, tau_a;
  } rows[] = {{"a spring", 1.0, 0.02, 100.0, 2.0},
              {"with gain", 0.25, 0.02, 100.0, 0.5},
              {"at its limit", 0.5, 0.4, 100.0, 5.0},
              {"at its other limit", 0.5, -0.4, 100.0, -5.0},
              {"a session's tighter one", 1.0, 0.02, 50.0, 1.0}};
  record.anchor.projection = core::ProjectionStatus::kExact;
  for (const auto& row : rows) {
    SCOPED_TRACE(row.what);
    record.life.gain = row.gain;
    record.anchor.x[0] = row.x;
    record.input.settings.stiffness[0] = row.stiffness;
    expect_force(row.tau_a);
  }
  record.anchor.projection = core::ProjectionStatus::kNone;
  expect_force(0.0);
}

TEST(RendererComparison, FreeImpossibleFingerIsNotPulled) {
  ComparedHand sound(3), broken(3);
  for (ComparedHand* hand : {&sound, &broken}) {
    hand->press();
    hand->record.anchor.free = 0b110u;
  }
  broken.record.sensed.q.segment<2>(4) << 0.02,
      -101 * kDegree;  // core/METHOD.md#map-without-a-value
  for (int tick = 0; tick < 3; ++tick) {
    const auto& expected = sound.comparison.evaluate(sound.record);
    const auto& tau = broken.comparison.evaluate(broken.record);
    for (std::size_t k = 0; k < tau.size(); ++k) {
      SCOPED_TRACE(std::string(core::name(core::kPaperRenderers[k])));
      EXPECT_EQ(tau[k], expected[k]);
      EXPECT_GT(std::abs(tau[k][0]), 0.2) << "N";
      EXPECT_EQ(tau[k][1], 0.0);
      EXPECT_EQ(tau[k][2], 0.0);
    }
  }
}

TEST(RendererComparison, PressedImpossibleFingerHasNoAnswer) {
  ComparedHand hand(2);
  hand.press();
  hand.record.sensed.q.segment<2>(2) << 0.02, -101 * kDegree;
  for (const core::VecA& tau : hand.comparison.evaluate(hand.record)) {
    for (const double force : tau) EXPECT_TRUE(std::isnan(force));
  }
}

/// The same as in the tick: fingers are devices of their own, the virtual stiffness of the
/// baselines included.
TEST(RendererComparison, FingerOfHandMatchesFingerAlone) {
  ComparedHand hand(4), alone(1);
  hand.press();
  alone.press();
  const auto& together = hand.comparison.evaluate(hand.record);
  const auto& single = alone.comparison.evaluate(alone.record);
  for (std::size_t k = 0; k < single.size(); ++k) {
    SCOPED_TRACE(std::string(core::name(core::kPaperRenderers[k])));
    EXPECT_GT(std::abs(single[k][0]), 0.2) << "N";
    EXPECT_NEAR(together[k][0], single[k][0], 1e-9);
  }
}

}  // namespace
}  // namespace haptic::server
