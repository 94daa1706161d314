#include "hw/replay/replay.hpp"
#include "hw/simulated/hand.hpp"
#include "hw/simulated/linear.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/linear.hpp"
#include "haptic/core/model/stylus.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::hw {
namespace {

using testing::HasSubstr;

std::shared_ptr<const core::Kinematics> linear(int n) {
  core::LinearMap map;
  for (int i = 0; i < n; ++i) {
    const std::string name = "z" + std::to_string(i);
    map.dofs.push_back({name, core::Unit::kMetre, i == 0, -1.0, 1.0});
    map.coordinates.push_back({name});
  }
  map.A = core::MatXQ::Identity(n, n);
  map.x_0 = core::VecX::Zero(n);
  return core::make_linear(map);
}

std::string error_of(const DeviceConfig& config,
                     std::shared_ptr<const core::Kinematics> kinematics) {
  return test::message_of<core::DeviceError>(
      [&] { return config.open(std::move(kinematics), {}); });
}

TEST(OpenDevice, AFingerNeedsTheFingersKinematics) {
  EXPECT_THAT(error_of(SimulatedHandConfig{}, linear(1)), HasSubstr("finger_exoskeleton"));
  EXPECT_THAT(error_of(SimulatedHandConfig{}, linear(2)), HasSubstr("finger_exoskeleton"));
}

TEST(OpenDevice, MassesGoWithAnyMap) {
  SimulatedLinearConfig config;
  config.mass = core::VecQ::Ones(6);
  config.max_effort = core::VecA::Ones(3);
  config.target = core::VecQ::Constant(6, 0.2);
  config.target[2] = -1.0;
  const auto stylus = config.open(core::make_stylus({}), {});
  core::DeviceReading reading;
  stylus->read(core::TimePoint(std::chrono::seconds(1)), reading);
  EXPECT_EQ(reading.sample.q, config.target) << "at rest on the target";
  EXPECT_EQ(stylus->info().dofs[1].name, "shoulder");
}

TEST(OpenDevice, ARecordingNeedsAnEffort) {
  ReplayConfig config;
  config.file = HAPTIC_SOURCE_DIR "/server/scenes/motion/reach_and_grasp.csv";
  EXPECT_THAT(error_of(config, core::make_finger_exoskeleton(core::finger_sign_change())),
              HasSubstr("max_effort: has 0 value(s); must have one per actuated DoF, 1"));
  config.max_effort = core::VecA::Constant(1, -3.0);
  EXPECT_THAT(error_of(config, core::make_finger_exoskeleton(core::finger_sign_change())),
              HasSubstr("max_effort[0] = -3: must be finite and > 0"));
}

}  // namespace
}  // namespace haptic::hw
