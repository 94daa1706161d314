#include "hw/board/calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/board/board_device.hpp"
#include "hw/device_limits.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::hw::board {
namespace {

core::VecQ two(double a, double b) {
  return (core::VecQ(2) << a, b).finished();
}

Calibration good() {
  return {.source = "hx-7.textproto",
          .serial = "HX-7",
          .date = "2026-11-21",
          .scale = two(1.25, -0.8),
          .offset = two(-0.004, 0.3),
          .lower = two(0.001, -1.2),
          .upper = two(0.049, 0.7),
          .force_zero = core::VecA::Constant(1, 0.7)};
}

std::string why_refused(const Calibration& c, const std::string& serial = "HX-7",
                        bool force = true) {
  return test::message_of<core::DeviceError>(
      [&] { check(c, *core::make_finger_exoskeleton(core::finger_sign_change()), serial, force); });
}

TEST(BoardCalibration, AppliesScaleOffsetAndZero) {
  core::DeviceSample sample{.q = two(0.02, 0.5), .tau_measured = core::VecA::Constant(1, 2.7)};
  apply(good(), sample);
  EXPECT_NEAR(sample.q[0], 1.25 * 0.02 - 0.004, 1e-15);
  EXPECT_NEAR(sample.q[1], -0.8 * 0.5 + 0.3, 1e-15);
  EXPECT_NEAR(sample.tau_measured[0], 2.0, 1e-15);
}

TEST(BoardCalibration, TheTravelBoundsSamples) {
  const auto kinematics = core::make_finger_exoskeleton(core::finger_sign_change());
  core::DeviceLimits limits = device_limits(*kinematics, core::VecA::Constant(1, 40.0));
  apply(good(), limits);
  EXPECT_NEAR(limits.q_lower[0], 0.001 - 0.05 * 0.048, 1e-15);
  EXPECT_NEAR(limits.q_upper[1], 0.7 + 0.05 * 1.9, 1e-15);
}

TEST(BoardCalibration, APositionGoesBackThroughIt) {
  const auto kinematics = core::make_finger_exoskeleton(core::finger_sign_change());
  const core::VecA reading =
      to_readings(good(), kinematics->layout(), core::VecA::Constant(1, 0.021));
  EXPECT_NEAR(1.25 * reading[0] - 0.004, 0.021, 1e-15);
}

TEST(BoardCalibration, ForcesAreSentInCellReadings) {
  BoardConfig config;
  config.max_effort = core::VecA::Constant(1, 40.0);
  config.calibration = good();
  DeviceSide side(config, core::make_finger_exoskeleton(core::finger_sign_change()),
                  core::Duration{0});
  Identity board{.capabilities = HB_MEASURES_FORCE | HB_FORCE_LOOP, .serial = "HX-7"};
  side.identify({board, {}});
  const auto sent = [&](const hw::Command& command) { return side.write(command).tau_a[0]; };
  const hw::Command press{true, core::VecA::Constant(1, 2.0), {}};
  for (int tick = 0; tick < 3; ++tick) {
    EXPECT_NEAR(sent(press), 2.7, 1e-15) << "the zero is added once, not once per tick";
  }
  EXPECT_NEAR(sent({true, {}, {}}), 0.7, 1e-15) << "no force at all";
  EXPECT_EQ(sent({false, press.tau_a, {}}), 0.0) << "what is not armed is told nothing";
  board.capabilities = HB_MEASURES_FORCE;
  side.identify({board, {}});
  EXPECT_EQ(sent(press), 2.0) << "a drive's force has no cell to be compared with";
}

TEST(BoardCalibration, AnotherDevicesIsRefusedByName) {
  EXPECT_EQ(why_refused(good()), "no error");
  EXPECT_EQ(
      why_refused(good(), "HX-8"),
      "calibration hx-7.textproto: was made with the device 'HX-7' on 2026-11-21, this one is "
      "'HX-8'; must be its own (hapticctl calibrate)");
}

TEST(BoardCalibration, AMisfitIsRefusedWithReason) {
  const struct {
    std::function<void(Calibration&)> change;
    const char* says;
  } table[] = {
      {[](Calibration& c) { c.scale[0] = 0.0; }, "DoF 'l_x': scale = 0: must be finite, not 0"},
      {[](Calibration& c) { c.upper[0] = 0.06; }, "DoF 'l_x': upper = 0.06: must be within"},
      {[](Calibration& c) { c.lower[1] = 0.7; }, "DoF 'q_B': lower = 0.7: must be below upper"},
      {[](Calibration& c) { c.offset.resize(1); }, "has 1 DoF(s); must have 2"},
      {[](Calibration& c) { c.force_zero.resize(0); }, "must have one per measured force, 1"},
  };
  for (const auto& [change, says] : table) {
    Calibration c = good();
    change(c);
    EXPECT_THAT(why_refused(c), testing::HasSubstr(says));
  }
  EXPECT_THAT(why_refused(good(), "HX-7", false), testing::HasSubstr("zero(s) of force"));
}

}  // namespace
}  // namespace haptic::hw::board
