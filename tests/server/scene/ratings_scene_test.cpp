#include "tests/server/scene/scene_text.hpp"

namespace haptic::test {
namespace {

std::string with_limits(const std::string& more) {
  return replaced(kFinger, "force_n: 20", "force_n: 20 " + more);
}

const std::string kThermal =
    "thermal { motor_constant: 4 winding_k_per_w: 6 winding_time_s: 12 limit_c: 105 ";

TEST(RatingsScene, AbsentMeansNone) {
  EXPECT_TRUE(parse(kFinger).devices[0].pipeline.ratings.empty());
  EXPECT_EQ(parse(kFinger).resolved.find("power_w"), std::string::npos);
}

TEST(RatingsScene, EachMayStandAlone) {
  const auto power = parse(with_limits("power_w: 2")).devices[0].pipeline.ratings;
  ASSERT_EQ(power.size(), 1u);
  EXPECT_EQ(power[0].power, 2.0);
  EXPECT_EQ(power[0].rate, std::numeric_limits<double>::infinity());
  EXPECT_FALSE(power[0].thermal);
  EXPECT_EQ(parse(with_limits("rate_m_per_s: 0.03")).devices[0].pipeline.ratings.at(0).rate, 0.03);
}

TEST(RatingsScene, TheThermalModelHasItsDocumentedDefaults) {
  const server::Scene scene = parse(with_limits(kThermal + "}"));
  const core::ThermalParameters p = *scene.devices[0].pipeline.ratings.at(0).thermal;
  EXPECT_EQ(p.motor_constant, 4.0);
  EXPECT_EQ(p.winding_resistance, 6.0);
  EXPECT_EQ(p.winding_time, 12.0);
  EXPECT_EQ(p.limit_c, 105.0);
  EXPECT_EQ(p.housing_resistance, 0.0);
  EXPECT_EQ(p.housing_time, 600.0);
  EXPECT_EQ(p.ambient_c, 25.0);
  EXPECT_EQ(p.derate_from_c, 85.0) << "a quarter of the way below the limit";
  EXPECT_EQ(parse(scene.resolved).resolved, scene.resolved);
}

TEST(RatingsScene, WhatIsWrongIsNamedWithItsPlace) {
  struct Case {
    std::string more, error;
  };
  const Case cases[] = {
      {"power_w: 0", "device[0].limits.power_w[0] = 0: must be > 0"},
      {"power_w: [1, 2]", "device[0].limits.power_w"},
      {"rate_m_per_s: -1", "device[0].limits.rate_m_per_s[0] = -1: must be > 0"},
      {"thermal { winding_k_per_w: 6 winding_time_s: 12 limit_c: 105 }",
       "device[0].limits.thermal[0].motor_constant: is required"},
      {kThermal + "ambient_c: 110 }",
       "device[0].limits.thermal[0].limit_c = 105: must be above ambient_c, 110"},
      {kThermal + "derate_from_c: 105 }",
       "device[0].limits.thermal[0].derate_from_c = 105: must be"},
      {kThermal + "} " + kThermal + "}", "device[0].limits.thermal = 2 of them: must be one per"},
  };
  for (const Case& c : cases) {
    EXPECT_NE(error_of(with_limits(c.more)).find(c.error), std::string::npos)
        << c.more << ":\n"
        << error_of(with_limits(c.more));
  }
}

/// A finger on a board, with force control.
std::string board(const std::string& force_control) {
  return replaced(kFinger, "simulated_finger {}",
                  "board { port: \"/dev/none\" max_effort: 40 }\n  " + force_control);
}

TEST(ForceControlScene, AbsentMeansThatNobodyAsks) {
  const auto device = parse(board("")).devices[0];
  EXPECT_EQ(device.force_control, server::ForceControlPlace::kAny);
  EXPECT_FALSE(device.pipeline.force_control.enabled());
}

TEST(ForceControlScene, OfTheServerIsALoopPerActuatedDof) {
  const server::Scene scene = parse(
      board("force_control { server { proportional: 2 integral_per_s: 30 friction_n: 12 } }"));
  const server::DeviceScene& device = scene.devices[0];
  EXPECT_EQ(device.force_control, server::ForceControlPlace::kServer);
  ASSERT_EQ(device.pipeline.force_control.loops.size(), 1u);
  const core::ForceLoopGains& gains = device.pipeline.force_control.loops[0];
  EXPECT_EQ(gains.proportional, 2.0);
  EXPECT_EQ(gains.integral, 30.0);
  EXPECT_EQ(gains.friction, 12.0);
  EXPECT_EQ(gains.friction_band, 1.0);
  EXPECT_EQ(gains.output_limit, 32.0) << "force_n and the friction";
  EXPECT_EQ(parse(scene.resolved).resolved, scene.resolved);
}

TEST(ForceControlScene, TheOutputStaysWithinWhatTheDeviceGives) {
  const auto gains = [](const std::string& more) {
    return parse(
               board("force_control { server { proportional: 2 integral_per_s: 30 " + more + "} }"))
        .devices[0]
        .pipeline.force_control.loops.at(0);
  };
  EXPECT_EQ(gains("friction_n: 31 ").output_limit, 40.0);
  const std::string error = error_of(
      board("force_control { server { proportional: 2 integral_per_s: 30 output_limit_n: 41 } }"));
  EXPECT_NE(error.find("output_limit_n[0] = 41: must be at most what the device can give, 40"),
            std::string::npos)
      << error;
}

TEST(ForceControlScene, AnAdmittanceTakesItsTravelFromTheDof) {
  const server::DeviceScene device =
      parse(board("force_control { admittance { damping_n_s_per_m: 400 max_rate_m_per_s: 0.03 } }"))
          .devices[0];
  EXPECT_EQ(device.force_control, server::ForceControlPlace::kAdmittance);
  ASSERT_EQ(device.pipeline.force_control.admittances.size(), 1u);
  const core::AdmittanceParameters& p = device.pipeline.force_control.admittances[0];
  EXPECT_EQ(p.mass, 0.0);
  EXPECT_EQ(p.damping, 400.0);
  EXPECT_EQ(p.max_rate, 0.03);
  EXPECT_EQ(p.lower, 0.0);
  EXPECT_EQ(p.upper, 0.05);
}

TEST(ForceControlScene, WhatIsWrongIsNamedWithItsPlace) {
  const std::string path = "device[0].force_control";
  EXPECT_NE(error_of(board("force_control {}")).find(path + ".where: is required"),
            std::string::npos);
  EXPECT_NE(error_of(board("force_control { server { integral_per_s: 30 } }"))
                .find(path + ".server.proportional"),
            std::string::npos);
  EXPECT_NE(error_of(board("force_control { admittance { damping_n_s_per_m: 400 "
                           "max_rate_m_per_s: 0.03 upper: 0.06 } }"))
                .find(path + ".admittance.upper[0] = 0.06: must be at most the DoF's own, 0.05"),
            std::string::npos);
  EXPECT_NE(error_of(replaced(kFinger, "limits {", "force_control { board {} }\n  limits {"))
                .find("must go with board: nothing else measures its force"),
            std::string::npos);
}

TEST(ForceControlScene, ADeviceThatCannotIsRefusedAtItsOpening) {
  using server::ForceControlPlace;
  hw::DeviceInfo device;
  const auto refused = [&](ForceControlPlace place) {
    try {
      server::check_force_control(place, device);
    } catch (const core::DeviceError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  EXPECT_EQ(refused(ForceControlPlace::kAny), "taken");
  EXPECT_NE(refused(ForceControlPlace::kBoard).find("does not close the loop"), std::string::npos);
  EXPECT_NE(refused(ForceControlPlace::kServer).find("measures no force"), std::string::npos);
  device.measures_force = true;
  EXPECT_EQ(refused(ForceControlPlace::kServer), "taken");
  EXPECT_NE(refused(ForceControlPlace::kAdmittance).find("positions"), std::string::npos);
  device.takes_positions = true;
  EXPECT_EQ(refused(ForceControlPlace::kAdmittance), "taken");
  device.closes_force_loop = true;
  EXPECT_NE(refused(ForceControlPlace::kServer).find("two loops in a row fight"),
            std::string::npos);
  EXPECT_EQ(refused(ForceControlPlace::kBoard), "taken");
}

}  // namespace
}  // namespace haptic::test
