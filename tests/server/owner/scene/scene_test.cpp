#include "server/owner/scene/scene.hpp"
#include "hw/simulated/hand.hpp"
#include "hw/simulated/linear.hpp"

#include "tests/server/owner/scene/scene_text.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

TEST(Scene, FillsInTheDocumentedDefaults) {
  const server::Scene scene = parse(kFinger);
  ASSERT_EQ(scene.devices.size(), 1u);
  const core::RenderSettings& s = scene.devices[0].pipeline.scene;
  EXPECT_EQ(s.renderer, core::RendererKind::kSubspaceLinear);
  EXPECT_TRUE(s.direction_guard);
  EXPECT_EQ(s.damping[0], 0.0);
  EXPECT_EQ(s.slew_limit[0], 2000.0) << "100 times force_n";
  EXPECT_EQ(s.engage_window[0], 5.0) << "0.25 times force_n";
  EXPECT_EQ(s.staleness.hold_end, 100ms);
  EXPECT_EQ(s.staleness.fade_end, 180ms);
  EXPECT_EQ(s.staleness.fresh_end, 80ms) << "the widest default a client may get";
  EXPECT_FALSE(scene.devices[0].fresh_end.has_value()) << "2.5 periods of the client";
  EXPECT_EQ(scene.server.listen, std::vector<std::string>{"127.0.0.1:29470"});
  EXPECT_EQ(scene.server.lease_timeout, 2s);
  EXPECT_EQ(scene.server.max_sessions, 32u);
  EXPECT_EQ(scene.loop.period, 1ms);
  EXPECT_EQ(scene.loop.priority, 80);
  EXPECT_FALSE(scene.loop.cpu.has_value());
  EXPECT_FALSE(scene.record.has_value()) << "presence selects";
}

TEST(Scene, HardwareDecidesTheDefaultsOnLateness) {
  for (const std::string& text : {kFinger, kLinear, kReplayed}) {
    const server::Scene wide = parse(text);
    EXPECT_EQ(wide.loop.loop_late_fault, std::optional<core::Duration>(1s));
    EXPECT_EQ(wide.devices[0].pipeline.late_bucket_full, 1'000'000);
  }
  const server::Scene strict = parse(kLinear + kBoard.substr(kBoard.find("device")));
  EXPECT_EQ(strict.devices[0].pipeline.late_bucket_full, 100);
  EXPECT_FALSE(strict.loop.loop_late_fault.has_value()) << "8 or 20 ms: the app decides";
  const server::Scene given =
      parse(kFinger, {"loop.late_bucket_full=50", "loop.loop_late_fault.nanos=9000000"});
  EXPECT_EQ(given.devices[0].pipeline.late_bucket_full, 50);
  EXPECT_EQ(given.loop.loop_late_fault, std::optional<core::Duration>(9ms));
}

TEST(Scene, GivenValuesReachTheirStructs) {
  const server::Scene scene =
      parse(replaced(kLinear, "limits {", R"(staleness {
    fresh_end { nanos: 15000000 }
    hold_end { nanos: 60000000 }
    fade_end { nanos: 110000000 }
  }
  null_space {}
  limits { slew_n_per_s: 7 engage_window_n: 1.5)") +
            R"(server { listen: ["[::1]:0", "unix:/run/h.sock"] lease_timeout { seconds: 5 }
                  max_sessions: 3 }
loop { period { nanos: 500000 } loop_late_fault { nanos: 4000000 } priority: 7 cpu: 1 }
record { file: "run.csv" compare_renderers: true })");
  const server::DeviceScene& device = scene.devices[0];
  EXPECT_EQ(device.pipeline.kinematics->layout().n_q(), 2);
  EXPECT_EQ(device.pipeline.kinematics->layout().n_a(), 1) << "derived, never typed";
  EXPECT_EQ(device.pipeline.scene.renderer, core::RendererKind::kNullSpace);
  EXPECT_EQ(device.pipeline.scene.slew_limit[0], 7.0);
  EXPECT_EQ(device.pipeline.scene.engage_window[0], 1.5);
  EXPECT_EQ(device.pipeline.scene.staleness, (core::StalenessLimits{15ms, 60ms, 110ms}));
  EXPECT_EQ(device.fresh_end, std::optional<core::Duration>(15ms));
  const auto& source = dynamic_cast<const hw::SimulatedLinearConfig&>(*device.source);
  EXPECT_EQ(source.mass[1], 2.0);
  EXPECT_EQ(source.max_effort.size(), 1);
  EXPECT_EQ(scene.server.listen, (std::vector<std::string>{"[::1]:0", "unix:/run/h.sock"}));
  EXPECT_EQ(scene.server.lease_timeout, 5s);
  EXPECT_EQ(scene.loop.period, 500us);
  EXPECT_EQ(scene.loop.loop_late_fault, std::optional<core::Duration>(4ms));
  EXPECT_EQ(scene.loop.cpu, std::optional<int>(1));
  ASSERT_TRUE(scene.record.has_value());
  EXPECT_EQ(scene.record->file, "run.csv");
  EXPECT_TRUE(scene.record->compare_renderers);
}

TEST(Scene, MatricesAreReadByRows) {
  const server::Scene scene =
      parse(replaced(replaced(kLinear, "A: [1, 0.5]", "A: [1, 2, 3, 4]"), "coordinate {",
                     "coordinate { name: \"y\" unit: \"m\" } coordinate {"));
  core::VecQ q(2);
  q << 0.1, 1.0;
  core::VecX x(2);
  core::MatXQ J(2, 2);
  ASSERT_EQ(scene.devices[0].pipeline.kinematics->evaluate(q, x, J), core::MapStatus::kOk);
  EXPECT_DOUBLE_EQ(x[0], 1 * 0.1 + 2 * 1.0);
  EXPECT_DOUBLE_EQ(x[1], 3 * 0.1 + 4 * 1.0);
}

TEST(Scene, ALinkageNamesItsDimensions) {
  const auto travel_of = [](const std::string& dimensions) {
    const server::Scene scene = parse(
        replaced(kFinger, "finger_exoskeleton {}", "finger_exoskeleton {" + dimensions + "}"));
    expect_resolved(scene, "linkage: \"finger_s");
    return scene.devices[0].pipeline.kinematics->dofs()[0].upper;
  };
  EXPECT_EQ(travel_of(""), 0.0335) << "finger_same_sign";
  EXPECT_EQ(travel_of("linkage: \"finger_same_sign\""), 0.0335);
  EXPECT_EQ(travel_of("linkage: \"finger_sign_change\""), 0.050);
  EXPECT_EQ(travel_of("linkage: \"finger_sign_change\" l_x_upper_m: 0.04"), 0.04);
}

TEST(Scene, RecordingsAreRelativeToTheScene) {
  const server::Scene scene = parse(replaced(kFinger, "simulated_finger {}",
                                             "simulated_finger { motion_file: \"motion/../motion/"
                                             "reach_and_grasp.csv\" }"));
  const auto& hand = dynamic_cast<const hw::SimulatedHandConfig&>(*scene.devices[0].source);
  EXPECT_EQ(hand.motion_file, kScenes / "motion/reach_and_grasp.csv");
  const server::Scene elsewhere = server::parse_scene(scene.resolved, "r", "/");
  EXPECT_EQ(dynamic_cast<const hw::SimulatedHandConfig&>(*elsewhere.devices[0].source).motion_file,
            hand.motion_file);
}

TEST(Scene, TheResolvedTextHoldsEveryDefault) {
  const std::string resolved = parse(kFinger).resolved;
  for (const char* field : {"seed: 1",
                            "hand_stiffness: 0.6",
                            "hand_damping: 0.012",
                            "actuator_mass_kg: 0.05",
                            "actuator_damping",
                            "actuator_force_limit_n: 40",
                            "proximal_phalanx_m: 0.045",
                            "damping_n_s_per_m: [0]",
                            "slew_n_per_s: [2000]",
                            "engage_window_n: [5]",
                            "hold_end",
                            "fade_end",
                            "subspace_linear",
                            "listen: \"127.0.0.1:29470\"",
                            "lease_timeout",
                            "max_sessions: 32",
                            "priority: 80",
                            "late_bucket_full: 1000000",
                            "# proto-file: haptic/v1/scene.proto\n",
                            "loop_late_fault {"}) {
    EXPECT_NE(resolved.find(field), std::string::npos) << field << "\n" << resolved;
  }
  EXPECT_EQ(resolved.find("record"), std::string::npos) << "absent stays absent";
}

TEST(Scene, WarnsOfATooStiffSpring) {
  // b = 2 N s/m, T = 1 ms: 2 b / T = 4000 N/m.
  EXPECT_TRUE(parse(replaced(kFinger, "1500", "4000")).warnings.empty());
  const server::Scene stiff = parse(replaced(kFinger, "1500", "4001"));
  ASSERT_EQ(stiff.warnings.size(), 1u);
  EXPECT_NE(
      stiff.warnings[0].find("device[0].impedance.stiffness_n_per_m[0] = 4001: is above 4000"),
      std::string::npos)
      << stiff.warnings[0];
  // Rendered damping counts against it, a slower loop too: 2 (2 - 0.5) / 2 ms = 1500.
  const std::vector<std::string> slower = {"device[0].impedance.damping_n_s_per_m=[0.5]",
                                           "loop.period={nanos: 2000000}"};
  EXPECT_TRUE(parse(kFinger, slower).warnings.empty());
  EXPECT_EQ(parse(replaced(kFinger, "1500", "1501"), slower).warnings.size(), 1u);
}

TEST(Scene, EachDeviceHasItsOwnRecord) {
  const std::string record = "record { file: \"out/run.csv\" }";
  EXPECT_EQ(server::record_file(parse(kFinger + record), 0), "out/run.csv");
  const server::Scene two = parse(kFinger + kLinear.substr(kLinear.find("device")) + record);
  EXPECT_EQ(server::record_file(two, 0), "out/run-finger.csv");
  EXPECT_EQ(server::record_file(two, 1), "out/run-d.csv");
}

TEST(Scene, AnUnreadableFileIsNamed) {
  const auto says = [](const std::filesystem::path& file) {
    return message_of<core::SceneError>([&] { return server::load_scene(file); });
  };
  EXPECT_NE(says("no/such.textproto").find("such.textproto: cannot be read: No such"),
            std::string::npos)
      << says("no/such.textproto");
  EXPECT_NE(says(kScenes).find("is a folder"), std::string::npos) << says(kScenes);
}

}  // namespace
}  // namespace haptic::test
