/// The rig with its force loop closed on the board.
#include "hw/emulator/emulated_board.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/hw/board/virtual_link.hpp"
#include "tests/hw/emulator/force_step.hpp"

namespace haptic::hw::emulator {
namespace {

using namespace std::chrono_literals;
using test::VirtualLink;

TEST(EmulatedBoard, ArmedAtZeroItYields) {
  VirtualLink link({}, test::expect_finger(), Eigen::Vector2d(0.6, 0.6));
  link.run(1s);
  const double locked = link.board.rig().finger().x().sum();
  link.arm(0.0);
  link.run(4s);
  // Switched off, friction holds the finger far from where its user wants it; armed, it gets there.
  EXPECT_LT(locked, 0.9);
  EXPECT_NEAR(link.board.rig().finger().x().sum(), 1.2, 0.1);
}

TEST(EmulatedBoard, ADriveThatIsOffRests) {
  VirtualLink link({}, test::expect_finger(), Eigen::Vector2d(0.5, 0.5));
  link.run(1s);
  link.arm(8.0);
  link.run(1s);
  const double x = link.board.rig().actuator().x();
  link.mute = true;
  link.run(500ms);
  EXPECT_FALSE(link.board.drives());
  EXPECT_NEAR(link.board.rig().actuator().x(), x, 2e-3);
  EXPECT_EQ(link.board.rig().actuator().v(), 0.0);
}

TEST(EmulatedBoard, OnlyTheDriftingReadingMoves) {
  EmulatorConfig config{.faults = {{FaultKind::kDrift, 0.5, 1e9, 0.001}}};
  VirtualLink link(config);
  link.run(2500ms);
  const double told = link.host.reading().q[0];
  EXPECT_NEAR(told - link.board.rig().actuator().x(), 0.002, 1e-4);
}

TEST(EmulatedBoard, TooMuchForceIsAFault) {
  EmulatorConfig config{.force_over_limit = 5.0};
  VirtualLink link(config);
  link.run(10ms);
  link.arm(15.0);
  link.run(2s);
  EXPECT_FALSE(link.board.drives());
  EXPECT_TRUE(link.host.reading().broken);
  EXPECT_TRUE(link.host.reading().force_over_limit) << "the reason outlives its cause";
}

/// The board's loop on an actuator that presses against a wall, the hardest case for stability.
class PressedLoop {
 public:
  /// The force in the cell 1 ms later, N.
  double tick(double reference) {
    const double measured = actuator_.force() + config_.sensors.noise_force * noise_();
    actuator_.drive(loop_.step(reference, measured, 1e-3), true);
    for (int i = 0; i < 10; ++i) actuator_.step(Rig::kStep, kWall, 0.0);
    return actuator_.force();
  }

 private:
  static constexpr double kWall = 0.02;  // m
  EmulatorConfig config_{};
  LinearActuator actuator_{config_.actuator, kWall};
  core::ForceLoop loop_{config_.force_loop};
  Gaussian noise_{config_.seed};
};

TEST(ForceStep, SettlesWithinTheLoopsPromise) {
  for (const double from : {2.0, 10.0}) {
    PressedLoop loop;
    const test::ForceStep step = test::measure_force_step(
        [&](double reference) { return loop.tick(reference); }, from, from + 4.0, 2000, 0.0725);
    std::printf("step %.0f to %.0f N: rise %.1f ms, bandwidth %.1f Hz, overshoot %.0f %%\n", from,
                from + 4.0, 1e3 * step.rise, step.bandwidth, 100.0 * step.overshoot);
    EXPECT_TRUE(step.settled);
    // hw/README.md: 87 Hz and 1 %; a rise is counted in ms, one more of which is 70 Hz.
    EXPECT_LT(step.overshoot, 0.02);
    EXPECT_GT(step.bandwidth, 65.0);
  }
}

}  // namespace
}  // namespace haptic::hw::emulator
