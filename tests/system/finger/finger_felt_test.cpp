// tests/report/STUDY.md#guarded-press: the rows of
// tests/report/STUDY.md#chosen-presses-finger_sign_change on the real Pipeline and the simulated
// finger, every renderer with the guard. Virtual time; the client has no delay.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "hw/simulated/finger.hpp"
#include "tests/support/angles.hpp"

namespace haptic {
namespace {

using core::VecA;
using core::VecQ;
using core::VecX;
using std::chrono::milliseconds;

constexpr double kNoStop = 999.0;

struct Row {
  double stop_mcp, stop_pip, stiffness;
};
constexpr Row kRows[] = {
    {18, kNoStop, 1500}, {18, kNoStop, 6000}, {kNoStop, 25, 1500}, {18, 25, 1500}};

struct Felt {
  double end_mcp{0}, end_pip{0};  ///< deg
  double end_force{0};            ///< N
  double worst_penetration{0};    ///< deg beyond a stop, at the end
  double work{0};                 ///< J put into the finger by the elastic force
  double most_against{0};         ///< most negative tau_x . dx in any tick, N m rad
};

Felt press(const Row& row, core::RendererKind kind, bool guard, bool force) {
  const std::shared_ptr<const core::Kinematics> finger =
      core::make_finger_exoskeleton(core::finger_sign_change());
  hw::SimulatedFingerConfig hand;
  hand.target_mcp = hand.target_pip = 50 * kDegree;
  const auto device = hand.open(finger, {});
  core::PipelineConfig config{.kinematics = finger, .device = device->info().limits};
  config.scene.renderer = kind;
  config.scene.direction_guard = guard;
  config.scene.stiffness = VecA::Constant(1, row.stiffness);
  config.scene.damping = VecA::Zero(1);
  config.scene.force_limit = VecA::Constant(1, 40.0);
  config.scene.slew_limit = VecA::Constant(1, 1e6);
  config.scene.engage_window = VecA::Constant(1, 40.0);
  core::Pipeline pipeline(config);

  core::TickInput input{.settings = config.scene};
  input.command.tenure = 1;
  input.command.lease_held = true;
  hw::Command command{true, VecA::Zero(1)};
  const VecX stop = (VecX(2) << row.stop_mcp * kDegree, row.stop_pip * kDegree).finished();
  Felt felt;
  double held_force = 0.0;
  VecQ last_q;
  for (int k = 1; k <= 3000; ++k) {
    input.now = core::TimePoint(milliseconds(k));
    device->read(input.now, input.device);
    const VecQ q = input.device.sample.q;
    VecX x_probe = VecX::Zero(2);
    core::MatXQ J;
    EXPECT_EQ(finger->evaluate(q, x_probe, J), core::MapStatus::kOk);
    input.proxy.mode = k == 1 ? core::ProxyMode::kFree : core::ProxyMode::kHeld;
    input.proxy.tenure = 1;
    ++input.proxy.seq;
    ++input.proxy.gapless_samples;
    input.proxy.gapless_since = core::TimePoint(milliseconds(1));
    input.proxy.born = input.now;
    input.proxy.x = x_probe.cwiseMin(stop);
    // The hand only closes after 0.8 s are over: force is on before the wall is met.
    if (force && k == 205) ++input.command.engage_id;
    const core::TickRecord record = pipeline.tick(input);
    if (last_q.size() == 2) felt.work += held_force * (q[0] - last_q[0]);
    held_force = record.effort.tau_a[0];
    last_q = q;
    // The torque that the finger feels: tau_x = w tau_a, w = (S J^{-1})^T.
    const double det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
    const VecX dx = input.proxy.x - x_probe;
    const double along = (J(1, 1) * dx[0] - J(0, 1) * dx[1]) / det;
    felt.most_against = std::min(felt.most_against, record.effort.tau_a[0] * along);
    command.arm = record.life.arm;
    command.tau_a = record.effort.tau_a;
    device->write(input.now, command);
    felt.end_mcp = x_probe[0] / kDegree;
    felt.end_pip = x_probe[1] / kDegree;
    felt.end_force = record.effort.tau_a[0];
  }
  felt.worst_penetration =
      std::max({0.0, felt.end_mcp - row.stop_mcp, felt.end_pip - row.stop_pip});
  return felt;
}

constexpr core::RendererKind kAll[] = {
    core::RendererKind::kStandard, core::RendererKind::kNullSpace,
    core::RendererKind::kSubspaceLinear, core::RendererKind::kSubspaceExact};

TEST(AtTheFinger, GuardedForceNeverLeavesTheProxy) {
  for (const Row& row : kRows) {
    const Felt none = press(row, core::RendererKind::kSubspaceLinear, true, false);
    EXPECT_NEAR(none.end_mcp, 50.0, 0.1);
    EXPECT_NEAR(none.end_pip, 50.0, 0.1);
    for (const core::RendererKind kind : kAll) {
      SCOPED_TRACE(::testing::Message() << core::name(kind) << ", stops " << row.stop_mcp << ", "
                                        << row.stop_pip << ", " << row.stiffness << " N/m");
      const Felt felt = press(row, kind, true, true);
      EXPECT_GE(felt.most_against, -1e-9);
      EXPECT_LE(felt.worst_penetration, none.worst_penetration + 0.5);
    }
  }
}

/// The end states of tests/report/STUDY.md#chosen-presses-finger_sign_change, for the default
/// renderer: (8).
TEST(AtTheFinger, TheLinearisedMethodEndsAsPublished) {
  struct End {
    Row row;
    double mcp, pip, force;
  };
  constexpr End kEnds[] = {{{18, kNoStop, 1500}, 47.4, 44.8, -4.6},
                           {{18, kNoStop, 6000}, 38.5, 29.2, -16.1},
                           {{kNoStop, 25, 1500}, 46.6, 43.3, -5.8},
                           {{18, 25, 1500}, 44.4, 39.1, -9.1}};
  for (const End& end : kEnds) {
    const Felt felt = press(end.row, core::RendererKind::kSubspaceLinear, true, true);
    EXPECT_NEAR(felt.end_mcp, end.mcp, 0.5);
    EXPECT_NEAR(felt.end_pip, end.pip, 0.5);
    EXPECT_NEAR(felt.end_force, end.force, 0.2);
    EXPECT_LT(felt.work, 0.0) << "a press takes energy from the finger";
  }
}

/// Without the guard the paper's alternatives can pull the finger into the wall: the reason it
/// exists.
TEST(AtTheFinger, UnguardedMethodsPullIntoTheWall) {
  const Row mcp = kRows[0];
  EXPECT_GT(press(mcp, core::RendererKind::kStandard, false, true).end_force, 5.0);
  EXPECT_GT(press(mcp, core::RendererKind::kSubspaceExact, false, true).end_force, 0.5);
  EXPECT_LT(press(mcp, core::RendererKind::kSubspaceExact, true, true).most_against + 1e-9, 1e-6);
}

}  // namespace
}  // namespace haptic
