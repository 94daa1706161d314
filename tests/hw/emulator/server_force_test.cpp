// Force control by the server over the board's link (hw/README.md, "Who closes the loop on the
// force?"): a step of the reference, the true force between rod and a finger that its hand holds,
// which is soft: the rod must travel for the force to change, and what slows it is the drive's own
// friction and speed. Virtual time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "haptic/core/control/force_control.hpp"
#include "tests/hw/emulator/force_step.hpp"
#include "tests/support/pressed_board.hpp"

namespace haptic::hw::emulator {
namespace {

/// Figures of hw/README.md for every pose: rise in s, overshoot as a share.
struct Figures {
  test::ForceLaw law{};
  double quickest{}, slowest{}, overshoot{};
};
const Figures kTable[] = {{test::kServerLoop, 0.211, 0.511, 0.02},
                          {test::kAdmittance, 0.091, 0.131, 0.03}};

/// N and N/s, as of a scene with force_n 20: slew by default, and all that the drive can give.
const core::DriveLimits kLimits{core::VecA::Constant(1, 50.0), core::VecA::Constant(1, 2000.0)};
constexpr double kOtherCompilers = 1.2;  // rounding differs, and with it the noise

/// The board under a law of the server's, one tick per millisecond.
class Loop {
 public:
  Loop(const test::ForceLaw& law, const Eigen::Vector2d& pose)
      : device_({.control = law.control}, {Eigen::Vector2d::Zero(), pose}, board_config(),
                core::make_finger_exoskeleton({})),
        law_(law.settings, 1) {}

  /// The true force after the tick, N.
  double tick(double reference) {
    now_ += std::chrono::milliseconds(1);
    device_.read(now_, reading_);
    if (reading_.armed) {
      law_.step(core::VecA::Constant(1, reference), reading_.sample.tau_measured, 1e-3, kLimits);
    } else if (reading_.sample.q.size() == 2) {
      law_.rest(reading_.sample.q.head(1));
    }
    device_.write(now_, {true, law_.drive().size() > 0 ? law_.drive() : core::VecA::Zero(1),
                         law_.position()});
    return device_.board().rig().actuator().force();
  }

 private:
  static BoardConfig board_config() {
    BoardConfig config;
    config.max_effort = core::VecA::Constant(1, 50.0);  // what the L16 lifts
    return config;
  }

  VirtualBoard device_;
  core::ForceControl law_;
  core::DeviceReading reading_{};
  core::TimePoint now_{};
};

TEST(ServerForce, AStepSettlesOverTheWorkspace) {
  for (const auto& [law, quickest, slowest, overshoot] : kTable) {
    for (const Eigen::Vector2d& pose :
         {Eigen::Vector2d(0.3, 0.3), Eigen::Vector2d(0.6, 0.8), Eigen::Vector2d(1.0, 1.2)}) {
      for (const double to : {-6.0, 6.0}) {
        Loop loop(law, pose);
        const test::ForceStep step = test::measure_force_step(
            [&](double reference) { return loop.tick(reference); }, to / 3.0, to, 3000, 0.05);
        std::printf(
            "%-13s at (%.1f, %.1f) rad, %2.0f to %2.0f N: rise %3.0f ms, bandwidth %5.1f Hz,"
            " overshoot %2.0f %%%s\n",
            law.name, pose[0], pose[1], to / 3.0, to, 1e3 * step.rise, step.bandwidth,
            100.0 * step.overshoot, step.settled ? "" : ", not settled");
        EXPECT_TRUE(step.settled);
        EXPECT_GT(step.rise, quickest / kOtherCompilers);
        EXPECT_LT(step.rise, slowest * kOtherCompilers);
        EXPECT_LT(step.overshoot, overshoot + 0.01);
      }
    }
  }
}

}  // namespace
}  // namespace haptic::hw::emulator
