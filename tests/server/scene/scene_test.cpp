#include "server/scene/scene.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <sstream>

#include "haptic/core/error.hpp"

namespace haptic::server {
namespace {

const std::filesystem::path kScenes = std::filesystem::path(HAPTIC_SOURCE_DIR) / "server/scenes";

const std::string kGood = R"(name: "t"
device {
  name: "finger"
  simulated_finger {}
  finger_exoskeleton {}
  impedance {
    stiffness_n_per_m: 1500
  }
  limits { force_n: 20 }
}
)";

Scene parse(const std::string& text, const std::vector<std::string>& set = {}) {
  return parse_scene(text, "t.textproto", kScenes, set);
}

std::string error_of(const std::string& text, const std::vector<std::string>& set = {}) {
  try {
    static_cast<void>(parse(text, set));
  } catch (const core::SceneError& error) {
    return error.what();
  }
  return "no error";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(Scene, FillsInTheDocumentedDefaults) {
  const Scene scene = parse(kGood);
  ASSERT_EQ(scene.devices.size(), 1u);
  const core::RenderSettings& s = scene.devices[0].settings;
  EXPECT_EQ(s.renderer, core::RendererKind::kSubspaceLinear);
  EXPECT_FALSE(s.direction_guard);
  EXPECT_EQ(s.damping[0], 0.0);
  EXPECT_EQ(s.slew_limit[0], 2000.0);
  EXPECT_EQ(s.engage_window[0], 5.0);
  EXPECT_EQ(s.staleness.hold_end, std::chrono::milliseconds(100));
  EXPECT_EQ(s.staleness.fade_end, std::chrono::milliseconds(180));
  EXPECT_FALSE(scene.devices[0].fresh_end.has_value()) << "2.5 periods of the client";
  EXPECT_EQ(scene.server.listen, std::vector<std::string>{"127.0.0.1:50051"});
  EXPECT_EQ(scene.server.lease_timeout, std::chrono::seconds(2));
  EXPECT_EQ(scene.loop.period, std::chrono::milliseconds(1));
  EXPECT_FALSE(scene.loop.loop_late_fault.has_value());
  EXPECT_FALSE(scene.record.has_value()) << "presence selects";
  const auto& hand = std::get<hw::SimulatedFingerConfig>(scene.devices[0].source);
  EXPECT_EQ(hand.hand_stiffness, 0.6);
  EXPECT_EQ(hand.actuator_force_limit, 40.0);
}

struct Bad {
  const char* what;
  std::string text;
  std::vector<const char*> says;  ///< every one of these stands in the message
};

TEST(Scene, SaysFileLineFieldValueAndWhatIsAllowed) {
  const std::string linear = R"(name: "t"
device {
  name: "d"
  simulated_linear { mass: 1 max_effort: 5 }
  linear {
    dof { name: "s" unit: "m" actuated: true lower: -1 upper: 1 }
    coordinate { name: "s" unit: "m" }
    A: 1
  }
  impedance { stiffness_n_per_m: 5 }
  limits { force_n: 2 }
}
)";
  const Bad kTable[] = {
      {"negative stiffness",
       replaced(kGood, "1500", "-3"),
       {"t.textproto:7: device[0].impedance.stiffness_n_per_m[0] = -3: must be > 0"}},
      {"not finite", replaced(kGood, "1500", "nan"), {":7:", "stiffness_n_per_m[0] = nan"}},
      {"unknown field",
       replaced(kGood, "stiffness_n_per_m", "stifness_n_per_m"),
       {"t.textproto:7:", "stifness_n_per_m", "Allowed here: stiffness_n_per_m, "}},
      {"syntax", replaced(kGood, "limits {", "limits ("), {"t.textproto:9:"}},
      {"wrong type", replaced(kGood, "1500", "\"much\""), {"t.textproto:7:"}},
      {"more force than the device gives",
       replaced(kGood, "force_n: 20", "force_n: 41"),
       {"t.textproto:9: device[0].limits.force_n[0] = 41: the device gives at most 40"}},
      {"too many values",
       replaced(kGood, "force_n: 20", "force_n: 20 force_n: 20"),
       {"device[0].limits.force_n = 2 values: must be one per actuated DoF, 1"}},
      {"no impedance", replaced(kGood, "impedance", "# impedance"), {"t.textproto:"}},
      {"no name", replaced(kGood, "name: \"t\"\n", ""), {"name: missing; must be given"}},
      {"bad device name",
       replaced(kGood, "\"finger\"", "\"My Finger\""),
       {"device[0].name = \"My Finger\": must be 1 to 32 of a-z"}},
      {"no source",
       replaced(kGood, "simulated_finger {}", ""),
       {"device[0].source: missing; must be one of simulated_finger, simulated_linear, replay"}},
      {"no kinematics",
       replaced(kGood, "finger_exoskeleton {}", ""),
       {"device[0].kinematics: missing"}},
      {"source and map do not go together",
       replaced(linear, "simulated_linear { mass: 1 max_effort: 5 }", "simulated_finger {}"),
       {"device[0].simulated_finger", "needs kinematics finger_exoskeleton"}},
      {"motion file",
       replaced(kGood, "simulated_finger {}", "simulated_finger { motion_file: \"none.csv\" }"),
       {"device[0].simulated_finger.motion_file", "none.csv", "must be a CSV file that exists"}},
      {"finger that cannot be",
       replaced(kGood, "finger_exoskeleton {}", "finger_exoskeleton { rod1_m: -1 }"),
       {"device[0].finger_exoskeleton.rod1_m = -1"}},
      {"finger that closes nowhere",
       replaced(kGood, "finger_exoskeleton {}", "finger_exoskeleton { rod1_m: 0.5 rod2_m: 0.5 }"),
       {"closes nowhere"}},
      {"staleness",
       replaced(kGood, "limits {", "staleness { fade_end { nanos: 120000000 } }\n limits {"),
       {"device[0].staleness", "fade_end - hold_end must be >= 50 ms"}},
      {"address",
       kGood + "server { listen: \"localhost\" }\n",
       {"t.textproto:11: server.listen[0] = \"localhost\": must be host:port"}},
      {"period",
       kGood + "loop { period { nanos: 1000 } }\n",
       {"loop.period = 0.001 ms: must be 0.5 ms to 10 ms"}},
      {"late fault",
       kGood + "loop { loop_late_fault { nanos: 1000000 } }\n",
       {"loop.loop_late_fault = 1 ms: must be 2 ms to 10000 ms"}},
      {"priority", kGood + "loop { priority: 99 }\n", {"loop.priority = 99: must be 1 to 98"}},
      {"record", kGood + "record { file: \"a.txt\" }\n", {"record.file = \"a.txt\""}},
      {"twice the same name",
       kGood + kGood.substr(kGood.find("device")),
       {"device[1].name = \"finger\": another device has this name"}},
      {"matrix size",
       replaced(linear, "A: 1", "A: 1 A: 2"),
       {"device[0].linear.A = 2 values: must be coordinates x dofs, 1 x 1"}},
      {"unit",
       replaced(linear, "unit: \"m\" actuated", "unit: \"mm\" actuated"),
       {"device[0].linear.dof[0].unit = \"mm\": must be \"m\" or \"rad\""}},
      {"nothing actuated", replaced(linear, "actuated: true ", ""), {"at least one must have"}},
      {"mass",
       replaced(linear, "mass: 1", "mass: 0"),
       {"device[0].simulated_linear.mass[0] = 0: must be > 0"}},
  };
  for (const Bad& bad : kTable) {
    const std::string message = error_of(bad.text);
    for (const char* part : bad.says) {
      EXPECT_NE(message.find(part), std::string::npos)
          << bad.what << "\n  wanted: " << part << "\n  got: " << message;
    }
  }
}

TEST(Scene, TellsEverythingThatIsWrongAtOnce) {
  std::string text = replaced(kGood, "1500", "-3");
  text = replaced(text, "force_n: 20", "force_n: -1") + "loop { priority: 0 }\n";
  const std::string message = error_of(text);
  EXPECT_NE(message.find("stiffness_n_per_m[0]"), std::string::npos);
  EXPECT_NE(message.find("force_n[0]"), std::string::npos);
  EXPECT_NE(message.find("loop.priority"), std::string::npos);
}

TEST(Scene, CoordinatesOfMixedUnitsAreRefusedWithoutAMetric) {
  const std::string message = error_of(R"(name: "t"
device {
  name: "d"
  simulated_linear { mass: 1 max_effort: 5 }
  linear {
    dof { name: "s" unit: "m" actuated: true lower: -1 upper: 1 }
    coordinate { name: "s" unit: "m" }
    coordinate { name: "a" unit: "rad" }
    A: 1 A: 2
  }
  impedance { stiffness_n_per_m: 5 }
  limits { force_n: 2 }
})");
  EXPECT_NE(message.find("coordinate[1].unit"), std::string::npos) << message;
  EXPECT_NE(message.find("W_x"), std::string::npos) << message;
}

TEST(SceneOverride, SetsAppendsCreatesAndReplaces) {
  const Scene scene =
      parse(kGood, {"device[0].impedance.stiffness_n_per_m[0]=800", "device[0].direction_guard={}",
                    "device[0].subspace_exact={}", "server.listen[0]=unix:/run/h.sock",
                    "server.listen[1]=\"127.0.0.1:0\"", "record.file=run.csv", "name=other"});
  EXPECT_EQ(scene.devices[0].settings.stiffness[0], 800.0);
  EXPECT_TRUE(scene.devices[0].settings.direction_guard);
  EXPECT_EQ(scene.devices[0].settings.renderer, core::RendererKind::kSubspaceExact);
  EXPECT_EQ(scene.server.listen, (std::vector<std::string>{"unix:/run/h.sock", "127.0.0.1:0"}));
  ASSERT_TRUE(scene.record.has_value());
  EXPECT_EQ(scene.record->file, "run.csv");
  EXPECT_EQ(scene.name, "other");
}

TEST(SceneOverride, NamesTheStepThatIsOffAndWhatExistsThere) {
  const auto says = [](const std::string& assignment, const std::string& part) {
    const std::string message = error_of(kGood, {assignment});
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_NE(message.find("--set " + assignment), std::string::npos) << message;
  };
  says("device[0].impedence.stiffness_n_per_m[0]=1", "no field 'impedence'; there are: impedance");
  says("device.name=x", "'device' is a list: say which, device[0]");
  says("device[5].name=x", "the list has 1");
  says("name[0]=x", "is one value, not a list");
  says("loop.priority=high", "'high' is not a int32");
  says("loop.priority", "must be path=value");
  says("device[x].name=y", "must be name or name[number]");
}

/// Every scene that is shipped loads, opens its devices, and is the same after a round trip.
TEST(Scene, EveryShippedSceneOpensAndItsResolvedTextIsTheSameScene) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kScenes)) {
    if (entry.path().extension() != ".textproto") continue;
    ++files;
    SCOPED_TRACE(entry.path().filename());
    const Scene scene = load_scene(entry.path());
    for (const DeviceScene& device : scene.devices) {
      EXPECT_NE(hw::open_device(device.source, device.kinematics), nullptr);
    }
    const Scene again = parse_scene(scene.resolved, "resolved", kScenes);
    EXPECT_EQ(again.resolved, scene.resolved);
    EXPECT_EQ(again.devices.size(), scene.devices.size());
  }
  EXPECT_GE(files, 8);
}

TEST(Scene, AFileThatIsNotThereIsNamed) {
  EXPECT_THROW(static_cast<void>(load_scene("no/such.textproto")), core::SceneError);
  EXPECT_THROW(static_cast<void>(load_scene(kScenes)), core::SceneError);
}

TEST(Scene, NoMutationOfTheTextDoesAnythingButLoadOrThrow) {
  std::ifstream stream(kScenes / "linear_underactuated.textproto");
  std::stringstream whole;
  whole << stream.rdbuf();
  const std::string text = whole.str();
  ASSERT_GT(text.size(), 100u);
  std::mt19937_64 random(7);
  int loaded = 0, refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string mutant = text;
    for (int k = 0; k < 1 + i % 4; ++k) {
      const std::size_t at = random() % mutant.size();
      switch (random() % 4) {
        case 0:
          mutant[at] = static_cast<char>(random());
          break;
        case 1:
          mutant.erase(at, 1 + random() % 20);
          break;
        case 2:
          mutant.insert(at, mutant.substr(random() % mutant.size(), random() % 30));
          break;
        default:
          mutant.insert(at, "-1e308");
          break;
      }
    }
    try {
      static_cast<void>(parse(mutant));
      ++loaded;
    } catch (const core::SceneError&) {
      ++refused;
    }
  }
  EXPECT_GT(loaded, 50);
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace haptic::server
