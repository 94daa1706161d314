// Options of a device: passivity, ratings, metric, tracker.
#include <Eigen/Core>

#include "hw/board/board_device.hpp"
#include "tests/server/owner/scene/scene_text.hpp"

namespace haptic::test {
namespace {

using std::chrono::milliseconds;

server::DeviceScene device_having(const std::string& option, const std::string& text = kFinger) {
  return parse(with_option(text, option)).devices[0];
}
std::string with_limits(const std::string& more) {
  return replaced(kFinger, "force_n: 20", "force_n: 20 " + more);
}
const std::string kThermal =
    "thermal { motor_constant: 4 winding_k_per_w: 6 winding_time_s: 12 limit_c: 105 ";

/// A slide on a palm; the tracker is on line 8.
const std::string kOnAPalm = R"(name: "t"
device {
  name: "d"
  simulated_linear { mass: [1, 1, 1, 1, 1, 1, 1] max_effort: 5 }
  serial_chain { palm {} joint { name: "s" kind: "prismatic" actuated: true lower: 0 upper: 1 }
    output { name: "w" link: "base" point {} }
    output { name: "t" point { position_m: [0.1, 0, 0] } } }
  impedance { stiffness_n_per_m: 5 }
  tracker {}
  limits { force_n: 2 }
  prior { weight: 0.1 sensed_stiffness: [3, 3, 3, 3, 3, 3] }
}
)";

TEST(DeviceOptions, AbsentMeansOff) {
  const server::Scene scene = parse(kFinger);
  const core::PipelineConfig& pipeline = scene.devices[0].pipeline;
  EXPECT_FALSE(pipeline.passivity.observer.enabled);
  EXPECT_TRUE(pipeline.ratings.empty());
  EXPECT_FALSE(pipeline.tracker.has_value());
  for (const char* field : {"observer", " power_w", "tracker"}) {
    EXPECT_EQ(scene.resolved.find(field), std::string::npos) << field;
  }
}

TEST(PassivityScene, DefaultsComeFromTheSimulatedDevice) {
  const server::Scene scene = parse(with_option(kFinger, "passivity { tank {} observer {} }"));
  const core::PassivitySettings& p = scene.devices[0].pipeline.passivity;
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
  expect_resolved(scene, "capacity_j: 0.05");
}

TEST(PassivityScene, GivenValuesReachTheirStructs) {
  const core::PassivitySettings p = device_having(R"(passivity {
    tank { initial_j: 0.002 capacity_j: 0.01 allowed_power_w: 0.5 }
    observer { allowance_j: 0.001 forgetting_j: 0.003 inertia_kg: 0.7 slowest_m_per_s: 0.02 }
    device_damping_n_s_per_m: 0.25
  })",
                                                  kLinear)
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

TEST(PassivityScene, OnlyActuatedDofsCount) {
  const auto p =
      device_having("unguarded {} passivity { observer {} }", kLinear).pipeline.passivity;
  ASSERT_EQ(p.observer.inertia.size(), 1);
  EXPECT_EQ(p.observer.inertia[0], 1.0);
  EXPECT_FALSE(p.tank.enabled);
}

TEST(PassivityScene, ARecordingHasNoDynamics) {
  expect_says(with_option(kReplayed, "passivity { observer {} }"), "inertia_kg");
  EXPECT_EQ(device_having("passivity { tank {} }", kReplayed).pipeline.passivity.device_damping[0],
            0.0);
}

TEST(SensorFilterScene, DefaultsDependOnTheSource) {
  const auto lags = [](const server::DeviceScene& device) {
    const core::SensorFilter& filter = device.pipeline.filter;
    return std::tuple(filter.sensed_lag, filter.rate_lag, filter.actuated_lag);
  };
  const core::Duration none{0}, most = milliseconds(20);
  const core::SensorFilter usual = core::kDefaultFilter;
  EXPECT_EQ(lags(device_having("")),
            std::tuple(usual.sensed_lag, usual.rate_lag, usual.actuated_lag));
  EXPECT_EQ(lags(device_having("sensor_filter { sensed_lag {} rate_lag {} actuated_lag {} }")),
            std::tuple(none, none, none));
  EXPECT_EQ(lags(device_having("sensor_filter { sensed_lag {} rate_lag { nanos: 20000000 } }")),
            std::tuple(none, most, usual.actuated_lag));
  EXPECT_EQ(lags(device_having("sensor_filter { actuated_lag { nanos: 20000000 } }")),
            std::tuple(usual.sensed_lag, usual.rate_lag, most));
  const server::DeviceScene replay = shipped_scene("finger_replay").devices[0];
  EXPECT_EQ(lags(replay), std::tuple(none, usual.rate_lag, none));
}

TEST(BoardScene, KnowsItsLinkagesName) {
  const auto linkage_of = [](const std::string& finger) {
    const std::string board =
        replaced(kFinger, "simulated_finger {}", "board { port: 'p' max_effort: 40 }");
    const server::Scene scene = parse(replaced(board, "exoskeleton {}", "exoskeleton " + finger));
    return dynamic_cast<const hw::BoardConfig&>(*scene.devices[0].source).linkage;
  };
  EXPECT_EQ(linkage_of("{}"), "finger_same_sign");
  EXPECT_EQ(linkage_of("{ linkage: 'finger_sign_change' }"), "finger_sign_change");
  EXPECT_EQ(linkage_of("{ rod1_m: 0.0101 }"), "");
}

TEST(RatingsScene, EachMayStandAlone) {
  const auto power = parse(with_limits("power_w: 2")).devices[0].pipeline.ratings;
  ASSERT_EQ(power.size(), 1u);
  EXPECT_EQ(power[0].power, 2.0);
  EXPECT_EQ(power[0].rate, std::numeric_limits<double>::infinity());
  EXPECT_FALSE(power[0].thermal);
  EXPECT_EQ(parse(with_limits("rate_m_per_s: 0.03")).devices[0].pipeline.ratings.at(0).rate, 0.03);
}

TEST(RatingsScene, TheThermalModelHasItsDefaults) {
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
  expect_resolved(scene, "derate_from_c: 85");
}

TEST(MetricScene, MatricesAreReadByRows) {
  const server::Scene scene = parse(with_option(kFinger, "metric { W: [4, 1, 1, 9] }"));
  const Eigen::MatrixXd W = scene.devices[0].pipeline.projection.metric.matrix();
  EXPECT_NEAR((W - (Eigen::Matrix2d() << 4, 1, 1, 9).finished()).norm(), 0.0, 1e-14);
  expect_resolved(scene, "W: [4, 1, 1, 9]");
  EXPECT_EQ(scene.resolved.find("scale_m"), std::string::npos);
}

TEST(MetricScene, AMatrixJoinsMetresAndRadians) {
  const std::string mixed = replaced(
      kLinear, "A: [1, 0.5]", "coordinate { name: \"a\" unit: \"rad\" }\n A: [1, 0.5, 0, 1]");
  const std::string unneeded = replaced(mixed, "prior { weight: 0.1 sensed_stiffness: 3 }", "");
  EXPECT_EQ(error_of(with_option(unneeded, "metric { W: [1e4, 20, 20, 1] }")), "no error");
}

TEST(TrackerScene, ItsDofsAreThePalms) {
  const server::Scene scene = parse(kOnAPalm);
  const server::DeviceScene& device = scene.devices.front();
  ASSERT_TRUE(device.pipeline.tracker.has_value());
  EXPECT_EQ(device.pipeline.tracker->first_dof, 0);
  EXPECT_EQ(device.pipeline.kinematics->dofs()[0].name, "palm.x");
  EXPECT_EQ(device.pipeline.tracker->staleness.hold_end, milliseconds(100));
  EXPECT_EQ(device.pipeline.tracker->staleness.fade_end, milliseconds(180));
  EXPECT_FALSE(device.tracker_fresh_end.has_value());
  expect_resolved(scene, "tracker {");
}

TEST(TrackerScene, ItsLimitsAreItsOwn) {
  const server::DeviceScene device =
      parse(replaced(kOnAPalm, "tracker {}",
                     "tracker { fresh_end { nanos: 30000000 } hold_end { nanos: 50000000 } "
                     "fade_end { nanos: "
                     "110000000 } }"))
          .devices[0];
  EXPECT_EQ(device.tracker_fresh_end, milliseconds(30));
  EXPECT_EQ(device.pipeline.tracker->staleness.hold_end, milliseconds(50));
  EXPECT_EQ(device.pipeline.tracker->staleness.fade_end, milliseconds(110));
  EXPECT_EQ(device.pipeline.scene.staleness.hold_end, milliseconds(100)) << "the proxy's";
}

TEST(DeviceOptions, ErrorsNamePlaceValueAndRule) {
  const std::string d = "device[0].";
  expect_each_value_says({
      {kFinger, d + "passivity.tank.initial_j=0.06", "must be at most capacity_j"},
      {kFinger, d + "passivity.tank.capacity_j=0", "must be > 0"},
      {kFinger, d + "passivity.tank.allowed_power_w=-1", "must be >= 0"},
      {kFinger, d + "passivity.device_damping_n_s_per_m=[1, 2]", "must have one value per"},
      {kFinger, d + "passivity.observer.inertia_kg[0]=0", "must be > 0"},
      {kFinger, d + "limits.power_w[0]=0", "must be > 0"},
      {kFinger, d + "sensor_filter.sensed_lag={nanos: 20000001}",
       " = 20.000001 ms: must be 0 ms to 20 ms"},
      {kFinger, d + "limits.power_w=[1, 2]", "must have one value per"},
      {kFinger, d + "limits.rate_m_per_s[0]=-1", "must be > 0"},
  });
  const auto finger = [](const std::string& option) { return with_option(kFinger, option); };
  expect_each_says({
      {"motor", with_limits("thermal { winding_k_per_w: 6 winding_time_s: 12 limit_c: 105 }"),
       "device[0].limits.thermal[0].motor_constant: is required"},
      {"ambient", with_limits(kThermal + "ambient_c: 110 }"),
       "device[0].limits.thermal[0].limit_c = 105: must be above ambient_c, 110"},
      {"derate", with_limits(kThermal + "derate_from_c: 105 }"),
       "device[0].limits.thermal[0].derate_from_c = 105: must be"},
      {"two motors", with_limits(kThermal + "} " + kThermal + "}"),
       "device[0].limits.thermal = 2 of them: must be one per"},
      {"no palm", finger("tracker {}"),
       "device[0].tracker = { ... } with a device that has no tracked palm: must go with "
       "tracked_hand, or with a serial_chain on a palm"},
      {"fade", replaced(kOnAPalm, "tracker {}", "tracker { fade_end { nanos: 120000000 } }"),
       "device[0].tracker.fade_end = 120 ms: must be at least hold_end + 50 ms"},
  });
}

}  // namespace
}  // namespace haptic::test
