#include "tests/server/scene/scene_text.hpp"

namespace haptic::test {
namespace {

TEST(PassivityScene, AbsentMeansOff) {
  const server::DeviceScene device = parse(kFinger).devices[0];
  EXPECT_FALSE(device.pipeline.passivity.enabled());
  EXPECT_FALSE(device.pipeline.monotone_envelope);
  EXPECT_EQ(parse(kFinger).resolved.find("passivity"), std::string::npos);
}

TEST(PassivityScene, FillsInTheDocumentedDefaultsFromTheSimulatedDevice) {
  const server::Scene scene =
      parse(with_option(kFinger, "passivity { tank {} observer {} }\n  monotone_envelope {}"));
  const server::DeviceScene& device = scene.devices[0];
  EXPECT_TRUE(device.pipeline.monotone_envelope);
  const core::PassivitySettings& p = device.pipeline.passivity;
  EXPECT_TRUE(p.tank.enabled);
  EXPECT_TRUE(p.observer.enabled);
  EXPECT_EQ(p.tank.initial, 0.0);
  EXPECT_EQ(p.tank.capacity, 0.05);
  EXPECT_EQ(p.tank.allowed_power, 0.0);
  EXPECT_EQ(p.observer.allowance, 0.0);
  EXPECT_EQ(p.observer.forgetting, 0.5e-3);
  ASSERT_EQ(p.device_damping.size(), 1);
  EXPECT_EQ(p.device_damping[0], 2.0) << "the simulated actuator's";
  EXPECT_EQ(p.observer.inertia[0], 0.05);
  EXPECT_EQ(core::check(p, 1), nullptr);
  EXPECT_NE(scene.resolved.find("capacity_j: 0.05"), std::string::npos);
  EXPECT_EQ(parse(scene.resolved).resolved, scene.resolved);
}

TEST(PassivityScene, GivenValuesReachTheirStructs) {
  const core::PassivitySettings p = parse(with_option(kLinear, R"(passivity {
    tank { initial_j: 0.002 capacity_j: 0.01 allowed_power_w: 0.5 }
    observer { allowance_j: 0.001 forgetting_j: 0.003 inertia_kg: 0.7 slowest_m_per_s: 0.02 }
    device_damping_n_s_per_m: 0.25
  })"))
                                        .devices[0]
                                        .pipeline.passivity;
  EXPECT_EQ(p.tank.initial, 0.002);
  EXPECT_EQ(p.tank.capacity, 0.01);
  EXPECT_EQ(p.tank.allowed_power, 0.5);
  EXPECT_EQ(p.observer.allowance, 0.001);
  EXPECT_EQ(p.observer.forgetting, 0.003);
  EXPECT_EQ(p.observer.inertia[0], 0.7);
  EXPECT_EQ(p.observer.slowest[0], 0.02);
  EXPECT_EQ(p.device_damping[0], 0.25);
}

TEST(PassivityScene, OfALinearDeviceTheActuatedDoFsCount) {
  const core::PassivitySettings p =
      parse(with_option(kLinear, "passivity { observer {} }")).devices[0].pipeline.passivity;
  ASSERT_EQ(p.observer.inertia.size(), 1);
  EXPECT_EQ(p.observer.inertia[0], 1.0);
  EXPECT_FALSE(p.tank.enabled);
}

TEST(PassivityScene, WhatIsNotAllowedIsNamed) {
  const auto says = [](const std::string& passivity, const std::string& what) {
    const std::string error = error_of(with_option(kFinger, passivity));
    EXPECT_NE(error.find(what), std::string::npos) << error;
  };
  says("passivity {}", "device[0].passivity.tank");
  says("passivity { tank { initial_j: 0.06 } }", "initial_j = 0.06: must be at most capacity_j");
  says("passivity { tank { capacity_j: 0 } }", "capacity_j");
  says("passivity { tank { allowed_power_w: -1 } }", "allowed_power_w");
  says("passivity { tank {} device_damping_n_s_per_m: [1, 2] }", "device_damping_n_s_per_m");
  says("passivity { observer { inertia_kg: 0 } }", "inertia_kg");
}

TEST(PassivityScene, ARecordingHasNoDynamicsToDeriveFrom) {
  const std::string replay =
      replaced(kFinger, "simulated_finger {}",
               "replay { file: \"motion/reach_and_grasp.csv\" max_effort: 40 }");
  const std::string error = error_of(with_option(replay, "passivity { observer {} }"));
  EXPECT_NE(error.find("inertia_kg"), std::string::npos) << error;
  const core::PassivitySettings p =
      parse(with_option(replay, "passivity { tank {} }")).devices[0].pipeline.passivity;
  EXPECT_EQ(p.device_damping[0], 0.0);
}

}  // namespace
}  // namespace haptic::test
