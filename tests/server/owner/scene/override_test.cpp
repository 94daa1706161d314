#include "hw/simulated/linear.hpp"
#include "tests/server/owner/scene/scene_text.hpp"

namespace haptic::test {
namespace {

TEST(SceneOverride, SetsOneEntryOfAList) {
  const auto scene = parse(kFinger, {"device[0].impedance.stiffness_n_per_m[0]=800"});
  EXPECT_EQ(scene.devices[0].pipeline.scene.stiffness[0], 800.0);
}

TEST(SceneOverride, SetsAWholeList) {
  const auto scene = parse(kLinear, {"device[0].simulated_linear.mass=[7, 8]",
                                     "server.listen=[\"127.0.0.1:1\", \"unix:/run/h\"]"});
  const auto& source = dynamic_cast<const hw::SimulatedLinearConfig&>(*scene.devices[0].source);
  EXPECT_EQ(source.mass[0], 7.0);
  EXPECT_EQ(source.mass[1], 8.0);
  EXPECT_EQ(scene.server.listen, (std::vector<std::string>{"127.0.0.1:1", "unix:/run/h"}));
  EXPECT_EQ(parse(kLinear, {"server.listen=127.0.0.1:9"}).server.listen,
            std::vector<std::string>{"127.0.0.1:9"});
}

TEST(SceneOverride, IndexAtSizeAppends) {
  const auto scene = parse(kFinger, {"server.listen[0]=unix:/run/h", "server.listen[1]=[::1]:0"});
  EXPECT_EQ(scene.server.listen, (std::vector<std::string>{"unix:/run/h", "[::1]:0"}));
}

TEST(SceneOverride, PresenceSelects) {
  const auto scene = parse(kFinger, {"device[0].direction_guard={}", "record.file=run.csv",
                                     "device[0].staleness.hold_end.nanos=50000000"});
  EXPECT_TRUE(scene.devices[0].pipeline.scene.direction_guard);
  EXPECT_EQ(scene.record->file, "run.csv");
  EXPECT_EQ(scene.devices[0].pipeline.scene.staleness.hold_end, std::chrono::milliseconds(50));
}

TEST(SceneOverride, AOneofIsReplaced) {
  const std::string with = replaced(kFinger, "limits {", "standard {}\n limits {");
  EXPECT_EQ(parse(with).devices[0].pipeline.scene.renderer, core::RendererKind::kStandard);
  EXPECT_EQ(parse(with, {"device[0].subspace_exact={}"}).devices[0].pipeline.scene.renderer,
            core::RendererKind::kSubspaceExact);
}

TEST(SceneOverride, QuotesAroundTextAreOptional) {
  EXPECT_EQ(parse(kFinger, {"name=\"in quotes\""}).name, "in quotes");
  EXPECT_EQ(parse(kFinger, {"name=without # = any"}).name, "without # = any");
}

TEST(SceneOverride, LaterOnesWin) {
  EXPECT_EQ(parse(kFinger, {"loop.priority=5", "loop.priority=6"}).loop.priority, 6);
}

TEST(SceneOverride, ErrorsNameTheCommandLine) {
  EXPECT_EQ(error_of(kFinger, {"device[0].impedance.stiffness_n_per_m[0]=-3"}),
            "--set: device[0].impedance.stiffness_n_per_m[0] = -3: must be > 0");
  EXPECT_EQ(error_of(kFinger, {"device[0].limits={}"}),
            "--set: device[0].limits.force_n: is required: one value per actuated DoF, 1");
  expect_says(kFinger, "--set: device[1].impedance: is required", {"device[1].name=b"});
}

TEST(SceneOverride, AWrongPathListsTheFields) {
  const auto says = [](const std::string& assignment, const std::string& part) {
    expect_says(kFinger, "--set " + assignment + ": " + part, {assignment});
  };
  says("device[0].impedence.x=1", "'impedence': no such field; there are: impedance, ");
  says("device.name=x", "'device': is a list, say which one: device[0]");
  says("device[5].name=x", "'device[5]': the list has 1; device[1] would append");
  says("device[0].impedance.stiffness_n_per_m[2]=1", "'stiffness_n_per_m[2]': the list has 1");
  says("name[0]=x", "'name[0]': name is no list, leave the index out");
  says("name.first=x", "'name': is a value, it has no fields of its own");
  says("device[x].name=y", "'device[x]': must be name or name[number]");
  says("device[99999999].name=y", "'device[99999999]': must be name or name[number]");
  says("=3", "must be path=value");
  says("loop.priority", "must be path=value");
  says(".=3", "'': must be name or name[number]");
}

TEST(SceneOverride, AWrongValueIsRefused) {
  const auto says = [](const std::string& assignment, const std::string& part) {
    expect_says(kFinger, "--set " + assignment + ": ", {assignment});
    expect_says(kFinger, part, {assignment});
  };
  says("loop.priority=high", "\"high\": must be a whole number");
  says("loop.priority=99999999999", "must be a whole number");
  says("server.max_sessions=-1", "must be a whole number >= 0");
  says("device[0].limits.force_n[0]=much", "\"much\": must be a number");
  says("device[0].limits.force_n[0]=", "\"\": must be a number");
  says("record.compare_renderers=maybe", "must be true or false");
  says("loop=5", "must be a message { field: value ... } with period, loop_late_fault, ");
  says("device[0].limits={forse_n: 1}", "forse_n: unknown field; allowed here: force_n, ");
  says("name=\"open", "must be text");
  // One --set sets one field.
  says("device[0].limits.force_n[0]=3 slew_n_per_s: 1", "must be one value");
  says("device[0].limits.force_n[0]=[1, 2]", "must be one value");
  says("loop.priority=5 cpu: 1", "must be one value");
}

TEST(SceneOverride, AllThatAreOffAreTold) {
  const std::vector<std::string> set = {"nam=x", "loop.priority=5", "loop.cpus=1"};
  expect_says(kFinger, "'nam': no such field; there are: name", set);
  expect_says(kFinger, "'cpus': no such field; there are: cpu", set);
}

/// A scene under any bytes: Fuzz.AnySceneLoadsOrIsRefused.
TEST(SceneOverride, DamagedOnesAreSetOrRefused) {
  const std::string pieces[] = {"",
                                "[",
                                "]",
                                "{",
                                "}",
                                "\"",
                                "-",
                                "nan",
                                std::string(1, '\0'),
                                "\xff\xfe",
                                "18446744073709551616"};
  int loaded = 0, refused = 0;
  for (const std::string seed :
       {"device[0].impedance.stiffness_n_per_m[0]=800", "server.listen=[\"127.0.0.1:1\"]",
        "device[0].standard={}", "loop={period {nanos: 2000000}}"}) {
    for (std::size_t at = 0; at < seed.size(); ++at) {
      for (const std::string& piece : pieces) {
        try {
          static_cast<void>(parse(kFinger, {std::string(seed).replace(at, 1, piece)}));
          ++loaded;
        } catch (const core::SceneError& error) {
          ASSERT_STRNE(error.what(), "");
          ++refused;
        }
      }
    }
  }
  EXPECT_GT(loaded, 0);
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace haptic::test
