// A linkage that cannot close (core/METHOD.md#map-without-a-value) in a hand of which the tick
// leaves fingers out: the failure is that of what something holds, and of nobody else.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "haptic/core/tick/probe_completion.hpp"
#include "tests/core/tick/moving_hand.hpp"

namespace haptic::core {
namespace {

using namespace test;

/// core/METHOD.md#map-without-a-value, in a finger that nothing can hold: the others do not notice.
/// Where a plane comes to name it, they do, as with a finger that was asked all the time.
TEST(UnprobedBesideFailure, OneThatCannotCloseDisturbsNobodyUntilAPlaneNamesIt) {
  const PipelineConfig config = hand_config(RendererKind::kSubspaceLinear, true);
  Pipeline sound(config), broken(config);
  ProbeCompletion completion(*config.kinematics);
  MovingHand hand(config);
  constexpr BlockSet kMiddle = 1u << 2;
  const auto planes_on = [&](std::initializer_list<int> fingers) {
    ProxySnapshot& p = hand.sample(ProxyMode::kPlanes);
    p.planes.normals.setZero(p.x.size(), static_cast<Eigen::Index>(fingers.size()));
    p.planes.offsets.setConstant(static_cast<Eigen::Index>(fingers.size()), 0.36);
    int k = 0;
    for (const int finger : fingers) p.planes.normals(2 * finger + 1, k++) = 1.0;
  };
  const auto break_middle = [](TickInput input) {
    break_finger(2, input);
    return input;
  };
  VecX before;
  double most = 0.0;
  for (int i = 0; i < 900; ++i) {
    hand.advance();
    if (i % 16 == 0) planes_on({0});
    const TickRecord expected = sound.tick(hand.input);
    TickRecord record = broken.tick(i < 600 ? hand.input : break_middle(hand.input));
    ASSERT_EQ(record.unprobed, kAllFingers & ~1u);
    completion.complete(record);
    if (i == 599) before = record.x_probe;
    if (i < 600) continue;
    ASSERT_FALSE(record.faults.any());
    ASSERT_EQ(record.projection, expected.projection);
    ASSERT_EQ(record.tau_elastic, expected.tau_elastic);
    for (int k = 0; k < 2 * kFingers; ++k) {
      ASSERT_EQ(record.x_probe[k], k / 2 == 2 ? before[k] : hand.probe()[k]) << k;
    }
    ASSERT_EQ(record.x[4], before[4]) << "free: the proxy is where the probe was last";
    most = std::max(most, record.tau_elastic.cwiseAbs().maxCoeff());
  }
  EXPECT_GT(most, 1.0);

  planes_on({0, 2});
  hand.advance();
  TickRecord named = broken.tick(break_middle(hand.input));
  EXPECT_EQ(named.projection, ProjectionStatus::kMapFailed);
  EXPECT_NE(named.unprobed & kMiddle, 0u) << "asked for, and without an answer so far";
  completion.complete(named);
  EXPECT_EQ(named.x_probe[4], before[4]);
  EXPECT_TRUE(named.x.allFinite());

  hand.advance();  // and back: f is there in this very tick
  TickRecord healed = broken.tick(hand.input);
  EXPECT_NE(healed.projection, ProjectionStatus::kMapFailed);
  EXPECT_EQ(healed.unprobed & (kMiddle | 1u), 0u);
  EXPECT_EQ(VecX(healed.x_probe.segment(4, 2)), VecX(hand.probe().segment(4, 2)));
}

/// What is kept of a failure is the anchor of the finger that something holds. The others are free.
TEST(UnprobedBesideFailure, IsNotPulledWhereAnotherThatPressesCannotClose) {
  for (const RendererKind renderer : kAllRenderers) {
    SCOPED_TRACE(std::string(name(renderer)));
    const PipelineConfig config = hand_config(renderer, true);
    Pipeline pipeline(config);
    MovingHand hand(config);
    double kept = 0.0, moved = 0.0;
    VecQ before;
    for (int i = 0; i < 700; ++i) {
      hand.advance();
      if (i % 16 == 0 && i <= 592) planes_into(hand, {{0, 0.05}});
      hand.input.proxy.born = hand.input.now;
      if (i == 599) before = hand.input.device.sample.q;
      if (i >= 600) break_finger(0, hand.input);
      const TickRecord record = pipeline.tick(hand.input);
      if (i < 600) continue;
      ASSERT_EQ(record.projection, ProjectionStatus::kMapFailed);
      ASSERT_FALSE(record.faults.any());
      ASSERT_EQ(record.unprobed, kAllFingers & ~1u);
      ASSERT_TRUE(unstretched(record, kAllFingers & ~1u)) << i;
      ASSERT_EQ(record.tau_elastic.tail(4), VecA::Zero(4)) << i;
      kept = std::max(kept, std::abs(record.q_star[0] - record.q[0]));
      moved = std::max(moved, (record.q - before).tail(8).cwiseAbs().maxCoeff());
      if (renderer == RendererKind::kStandard || renderer == RendererKind::kNullSpace) continue;
      // The book's V is the one spring's that is left (core/METHOD.md#energy-tank; the baselines'
      // is stiffer).
      const double K = config.scene.stiffness[0];
      const double d = std::abs(record.q_star[0] - record.q[0]);
      const double beyond = kForceLimit * d - 0.5 * kForceLimit * kForceLimit / K;
      const double V = record.gain * (K * d <= kForceLimit ? 0.5 * K * d * d : beyond);
      ASSERT_NEAR(record.passivity.storage, V, 1e-12);
    }
    EXPECT_GT(moved, 0.005) << "m; 7.5 N at 1500 N/m";
    EXPECT_GT(kept, 1e-4) << "its own spring stays alive";
  }
}

/// A finger that was free for long is judged by where it is, whatever became of another.
TEST(UnprobedBesideFailure, NamedBesideOneThatCannotCloseItIsJudgedByWhereItIs) {
  for (const bool in_the_way : {true, false}) {
    const PipelineConfig config = hand_config(RendererKind::kSubspaceLinear, false);
    Pipeline pipeline(config);
    ProbeCompletion completion(*config.kinematics);
    MovingHand hand(config);
    hand.advance();
    const VecX first = hand.probe();
    planes_into(hand, {{0, -0.1}, {2, -kFar}});
    static_cast<void>(pipeline.tick(hand.input));
    hand.sample(ProxyMode::kFree);
    VecX now = first;
    // Until the finger has bent, or straightened, well away from where f was last asked for.
    for (int i = 0; i < 2000 && (in_the_way ? now[1] < first[1] + 0.04 : now[1] > first[1] - 0.04);
         ++i) {
      hand.advance();
      static_cast<void>(pipeline.tick(hand.input));
      now = hand.probe();
    }
    ASSERT_GT(std::abs(now[1] - first[1]), 0.03);
    planes_into(hand, {{0, in_the_way ? 0.02 : -0.02}, {2, -kFar}});
    hand.advance();
    now = hand.probe();
    break_finger(2, hand.input);
    TickRecord record = pipeline.tick(hand.input);
    EXPECT_EQ(record.unprobed, kAllFingers & ~1u);
    EXPECT_EQ(record.active_planes, in_the_way ? 1u : 0u);
    EXPECT_EQ(record.planes != PlaneStatus::kFree, in_the_way);
    EXPECT_EQ(record.projection,
              in_the_way ? ProjectionStatus::kMapFailed : ProjectionStatus::kNone);
    EXPECT_EQ(VecX(record.x_probe.head(2)), VecX(now.head(2)));
    completion.complete(record);
    const double at = in_the_way ? hand.input.proxy.planes.offsets[0] : now[1];
    EXPECT_NEAR(record.x[1], at, 1e-12) << "on the plane that holds it";
  }
}

}  // namespace
}  // namespace haptic::core
