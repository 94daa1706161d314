/// Intent of a simulated hand's user: recordings with some columns, and wrong ones.
#include "hw/simulated/hand_intent.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "haptic/core/error.hpp"
#include "haptic/core/model/rigid_pose.hpp"
#include "haptic/core/model/stylus.hpp"
#include "hw/simulated/hand.hpp"
#include "tests/hw/simulated/one_finger.hpp"
#include "tests/support/message_of.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::hw {
namespace {

using testing::HasSubstr;

/// A hand on a palm that follows `csv`; the target of all coordinates is 0.1.
SimulatedHand playing(const std::string& csv) {
  const test::TemporaryFile file(csv);
  SimulatedHandConfig config;
  config.fingers = 5;
  config.target = core::VecQ::Constant(16, 0.1);
  config.motion_file = file.path();
  return {config, test::hand_on_a_palm()};
}

std::string error_of(const std::string& csv) {
  return test::message_of<core::DeviceError>([&] { return playing(csv); });
}

TEST(HandIntent, AbsentColumnsStayAtTheTarget) {
  const SimulatedHand hand = playing(
      "time_s,palm.z,palm.x,palm.y,middle.q_o2_pip_rad,middle.q_o1_mcp_rad\n"
      "0,0.3,-0.2,0,0.8,0.4\n1,0.3,-0.2,0.5,0.8,0.4\n2,0.3,-0.2,0.5,0.8,0.4\n");
  EXPECT_THAT(hand.info().model, HasSubstr("1 of 5 fingers follow"));
  const std::vector<double> expected{-0.2, 0.5, 0.3, 0.1, 0.1, 0.1, 0.1, 0.1,
                                     0.1,  0.1, 0.4, 0.8, 0.1, 0.1, 0.1, 0.1};
  for (int i = 0; i < 16; ++i) {
    EXPECT_NEAR(hand.intent().at(1.5)[i], expected[static_cast<std::size_t>(i)], 1e-12) << i;
  }
}

TEST(HandIntent, ThePalmStartsThereFingersRise) {
  const SimulatedHand hand = playing(
      "time_s,palm.x,palm.y,palm.z,index.q_o1_mcp_rad,index.q_o2_pip_rad\n"
      "0,0.3,0.2,0.1,0.4,0.6\n1,0.3,0.2,0.1,0.4,0.6\n");
  EXPECT_NEAR(hand.intent().at(0.0)[0], 0.3, 1e-15);
  EXPECT_EQ(hand.intent().at(0.0)[8], 0.0);
  EXPECT_EQ(hand.intent().at(0.0)[10], 0.0) << "a finger without columns rises to its target too";
  EXPECT_NEAR(hand.palm()->ahead(0.0).position[0], 0.3, 1e-15);
  EXPECT_EQ(hand.fingers()[1].x().norm(), 0.0);
}

TEST(HandIntent, QuaternionsMayTurnThroughPi) {
  // About z by 170, 190, 210 degrees; signs and lengths of the quaternions are the file's affair.
  const auto row = [](double time, double degrees, double scale) {
    const double half = 0.5 * degrees * std::numbers::pi / 180.0;
    return std::to_string(time) + ",0,0," + std::to_string(scale * std::sin(half)) + "," +
           std::to_string(scale * std::cos(half)) + "\n";
  };
  const SimulatedHand hand = playing("time_s,palm.qx,palm.qy,palm.qz,palm.qw\n" + row(0, 170, 1) +
                                     row(1, 190, -2) + row(2, 210, 0.5));
  EXPECT_NEAR(hand.intent().at(1.0)[5], 190.0 * std::numbers::pi / 180.0, 1e-4);
  EXPECT_NEAR(hand.intent().at(2.0)[5], 210.0 * std::numbers::pi / 180.0, 1e-4);
  EXPECT_NEAR(hand.intent().at(1.5)[3], 0.0, 1e-12);
}

TEST(HandIntent, NamesWhatAFileLacks) {
  const std::string zeros = "\n0,0,0,0,0,0\n1,0,0,0,0,0\n";
  EXPECT_EQ(error_of("time_s,palm.x,palm.y,palm.z,a,b" + zeros), "no error");
  EXPECT_THAT(error_of("time_s,index.q_o1_mcp_rad" + zeros),
              HasSubstr("(missing: index.q_o2_pip_rad)"));
  EXPECT_THAT(error_of("time_s,palm.x,palm.z" + zeros), HasSubstr("(missing: palm.y)"));
  EXPECT_THAT(error_of("time_s,palm.rx,palm.ry" + zeros), HasSubstr("(missing: palm.rz)"));
  EXPECT_THAT(error_of("time_s,palm.qx,palm.qy,palm.qw" + zeros), HasSubstr("(missing: palm.qz)"));
  EXPECT_THAT(error_of("palm.x,palm.y,palm.z" + zeros), HasSubstr("(missing: time_s)"));
  const std::string none = error_of("time_s,q_o1_mcp_rad,q_o2_pip_rad" + zeros);
  EXPECT_THAT(none, HasSubstr("columns found: time_s, q_o1_mcp_rad, q_o2_pip_rad"));
  EXPECT_THAT(none, HasSubstr("palm.x, palm.y, palm.z, palm.rx"));
  EXPECT_THAT(none, HasSubstr("little.q_o2_pip_rad"));
}

TEST(HandIntent, NamesPlaceOfAWrongValue) {
  const std::string palm = "time_s,palm.x,palm.y,palm.z\n0,0,0,0\n";
  EXPECT_THAT(error_of(palm + "1,0,nan,0\n"), HasSubstr(":3: column palm.y = 'nan'"));
  EXPECT_THAT(error_of(palm + "1,0,0,1.5\n"),
              HasSubstr(":3: column palm.z = 1.5: must lie within the device's range, -1 to 1"));
  EXPECT_THAT(error_of(palm), HasSubstr("has 1 row(s) below its header"));
  EXPECT_THAT(error_of(""), HasSubstr("is empty"));
}

TEST(HandIntent, AHandNeedsAHandsKinematics) {
  const auto refuses = [](const SimulatedHandConfig& config,
                          std::shared_ptr<const core::Kinematics> kinematics) {
    return test::message_of<core::DeviceError>(
        [&] { return config.open(std::move(kinematics), {}); });
  };
  SimulatedHandConfig config;
  config.fingers = 5;
  config.target = core::VecQ::Zero(16);
  EXPECT_EQ(refuses(config, test::hand_on_a_palm()), "no error");
  EXPECT_THAT(refuses(config, test::one_finger()), HasSubstr("number of fingers = 5"));
  EXPECT_THAT(refuses(config, core::make_stylus({})),
              HasSubstr("6 DoF(s), 0 finger(s); must be finger_exoskeleton, hand_exoskeleton or"));
  config.fingers = 4;
  EXPECT_THAT(refuses(config, test::hand_on_a_palm()), HasSubstr("number of fingers = 4"));
  config.fingers = 5;
  config.target = core::VecQ::Zero(10);
  EXPECT_THAT(refuses(config, test::hand_on_a_palm()), HasSubstr("size of target = 10"));
  config.target = core::VecQ::Zero(16);
  config.motion_file = "no/such.csv";
  EXPECT_THAT(refuses(config, test::hand_on_a_palm()), HasSubstr("no/such.csv: cannot be read"));
}

}  // namespace
}  // namespace haptic::hw
