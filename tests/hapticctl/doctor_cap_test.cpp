// The stiffness that the doctor allows (core/METHOD.md#sampled-data), on the emulated board with
// the force loop in the server: a proxy held beside the finger, over a grid of the workspace, must
// come to rest. Virtual time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "doctor/examine.hpp"
#include "tests/support/pressed_board.hpp"

namespace haptic::ctl {
namespace {

using test::ForceLaw;

/// Damping of linkage and finger at the rod (hw/README.md), and the damping that the scene renders.
constexpr double kDeviceDamping = 0.5, kRenderedDamping = 0.0;  // N s/m

/// Stiffness that hapticctl doctor says for a host that is never late and whose serial ports add
/// nothing.
double allowed_stiffness() {
  StiffnessQuestion question{.device_damping = kDeviceDamping,
                             .rendered_damping = kRenderedDamping};
  HostAnswers answers;
  answers.jitter.ticks = 10'000;
  const StiffnessCap cap = examine(HostFiles("/nonexistent"), answers, question).cap;
  return std::min(cap.passive, cap.stable);
}

using Finger = std::shared_ptr<const core::Kinematics>;

/// How much force and rod still move in the last half second of 7 s of pressing.
struct Rest {
  bool engaged{true};  ///< all the while
  double force{0.0};   ///< N, mean of the true one
  double ripple{0.0};  ///< N, from peak to peak
  double travel{0.0};  ///< m
};

/// A finger that its hand bends to `pose`, rad, and an object that keeps it 0.2 rad out of it.
Rest press(const ForceLaw& law, double stiffness, const Finger& finger, const core::VecX& pose) {
  constexpr int kPressing = 6500, kLooking = 500;  // ms
  test::PressedBoard pressed(
      {.emulator = {.control = law.control},
       .finger = finger,
       .aim = pose,
       .proxy = [&](const core::VecX&) { return core::VecX(pose - core::VecX::Constant(2, 0.2)); },
       .max_effort = 50.0,  // what the L16 lifts
       .stiffness = stiffness,
       .damping = kRenderedDamping,
       .engage_window = 40.0,
       .direction_guard = false,
       .force_control = law.settings});
  pressed.run_ms(kPressing);
  Rest rest;
  const auto& actuator = pressed.board().rig().actuator();
  double lowest = 1e9, highest = -1e9, first = 1e9, last = -1e9;
  for (int i = 0; i < kLooking; ++i) {
    rest.engaged = pressed.tick().life.state == core::LifecycleState::kEngaged && rest.engaged;
    rest.force += actuator.force() / kLooking;
    lowest = std::min(lowest, actuator.force());
    highest = std::max(highest, actuator.force());
    first = std::min(first, actuator.x());
    last = std::max(last, actuator.x());
  }
  rest.ripple = highest - lowest;
  rest.travel = last - first;
  return rest;
}

/// The worst of every pose of the grid.
struct Worst {
  int poses{0}, engaged{0};
  double force{0.0}, ripple{0.0}, travel{0.0};
};

Worst over_the_workspace(const ForceLaw& law, double stiffness,
                         const core::FingerDimensions& dimensions) {
  const Finger finger = core::make_finger_exoskeleton(dimensions);
  Worst worst;
  for (double mcp = 0.2; mcp < 1.25; mcp += 0.3) {
    for (double pip = 0.2; pip < 1.45; pip += 0.4) {
      const core::VecX pose = (core::VecX(2) << mcp, pip).finished();
      core::VecQ q;
      if (finger->inverse(pose, q) != core::InverseStatus::kExact) continue;
      const Rest rest = press(law, stiffness, finger, pose);
      ++worst.poses;
      worst.engaged += rest.engaged ? 1 : 0;
      worst.force = std::max(worst.force, std::abs(rest.force));
      worst.ripple = std::max(worst.ripple, rest.ripple);
      worst.travel = std::max(worst.travel, rest.travel);
    }
  }
  std::printf("%-13s at %.0f N/m, %d poses: up to %.1f N; still moving by %.2f N and %.0f um\n",
              law.name, stiffness, worst.poses, worst.force, worst.ripple, 1e6 * worst.travel);
  return worst;
}

const ForceLaw kLaws[] = {test::kServerLoop, test::kAdmittance};

TEST(DoctorsCap, IsStableOverTheWorkspace) {
  const double stiffness = allowed_stiffness();
  // core/METHOD.md#sampled-data: 2 (b - B) / T and (b + B) / (T / 2), with b = 0.5, B = 0, T = 1
  // ms.
  ASSERT_NEAR(stiffness, 1000.0, 1e-6);
  for (const core::FingerDimensions& linkage :
       {core::FingerDimensions{}, core::finger_sign_change()}) {
    for (const ForceLaw& law : kLaws) {
      const Worst worst = over_the_workspace(law, stiffness, linkage);
      EXPECT_GE(worst.poses, 12);
      EXPECT_EQ(worst.engaged, worst.poses);
      EXPECT_GT(worst.force, 2.0) << "there was something to hold";
      EXPECT_LT(worst.ripple, 0.3);
      EXPECT_LT(worst.travel, 5e-5);
    }
  }
}

/// The positive control: the test above fails at four times the stiffness on one linkage. On the
/// other the press comes to rest there too.
TEST(DoctorsCap, FourTimesTheCapIsNot) {
  for (const ForceLaw& law : kLaws) {
    const double stiffness = 4.0 * allowed_stiffness();
    EXPECT_GT(over_the_workspace(law, stiffness, core::finger_sign_change()).ripple, 2.0);
  }
}

}  // namespace
}  // namespace haptic::ctl
