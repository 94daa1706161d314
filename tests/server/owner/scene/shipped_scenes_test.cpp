#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>

#include <fstream>
#include <set>
#include <typeinfo>

#include "haptic/v1/scene.pb.h"
#include "hw/board/board_device.hpp"
#include "server/owner/state/device_message.hpp"
#include "tests/server/owner/scene/scene_text.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::test {
namespace {

namespace fs = std::filesystem;

class ShippedScene : public testing::TestWithParam<std::string> {
 protected:
  const server::Scene scene = shipped_scene(GetParam());
};

TEST_P(ShippedScene, OpensItsDevices) {
  for (const server::DeviceScene& device : scene.devices) {
    if (device.source->is_hardware()) continue;
    const auto opened = device.source->open(device.pipeline.kinematics, {});
    ASSERT_NE(opened, nullptr);
    EXPECT_EQ(opened->info().limits.max_effort.size(), device.pipeline.scene.force_limit.size());
  }
}

TEST_P(ShippedScene, ResolvedTextReadsBackTheSame) {
  const server::Scene again = server::parse_scene(scene.resolved, "resolved", "/");
  EXPECT_EQ(again.resolved, scene.resolved);
  ASSERT_EQ(again.devices.size(), scene.devices.size());
  for (std::size_t i = 0; i < scene.devices.size(); ++i) {
    const server::DeviceScene &a = again.devices[i], &b = scene.devices[i];
    const hw::DeviceConfig &of_a = *a.source, &of_b = *b.source;
    EXPECT_EQ(typeid(of_a), typeid(of_b));
    EXPECT_EQ(a.pipeline.scene.renderer, b.pipeline.scene.renderer);
    EXPECT_EQ(a.pipeline.scene.staleness, b.pipeline.scene.staleness);
    EXPECT_EQ(server::describe(a.name, {}, a.pipeline).SerializeAsString(),
              server::describe(b.name, {}, b.pipeline).SerializeAsString());
  }
}

TEST_P(ShippedScene, IsGuardedAndWarnsOfNothing) {
  EXPECT_THAT(scene.warnings, testing::IsEmpty());
  for (const server::DeviceScene& device : scene.devices) {
    EXPECT_TRUE(device.pipeline.scene.direction_guard);
    EXPECT_TRUE(device.pipeline.passivity.tank.enabled);
  }
}

INSTANTIATE_TEST_SUITE_P(Of, ShippedScene, testing::ValuesIn(shipped_names()),
                         [](const auto& test) { return test.param; });

std::vector<fs::path> scenes_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".textproto") files.push_back(entry.path());
  }
  return files;
}

TEST(SceneFragments, LoadAndReadBack) {
  // A copy, with the PEM files that a fragment names.
  const ScratchFolder scratch;
  const fs::path& folder = scratch.path();
  fs::copy(kScenes / "fragments", folder);
  for (const char* pem : {"server.crt", "server.key", "clients.crt"}) std::ofstream(folder / pem);
  for (const fs::path& file : scenes_in(folder)) {
    if (file.stem().extension() == ".calibration") continue;  // loaded by the boards
    SCOPED_TRACE(file.filename());
    const server::Scene scene = server::load_scene(file);
    EXPECT_EQ(server::parse_scene(scene.resolved, "resolved", "/").resolved, scene.resolved);
    EXPECT_THAT(scene.warnings, testing::Each(testing::HasSubstr(".unguarded: ")))
        << "one of them shows the word";
  }
}

using Fields = std::set<std::string>;  // full names: "haptic.v1.Scene.device"

/// The fields of a type and of the messages within it.
void add_fields(const google::protobuf::Descriptor& type, Fields& all) {
  for (int i = 0; i < type.field_count(); ++i) {
    const auto& field = *type.field(i);
    const bool is_new = all.insert(field.full_name()).second;
    const auto* inner = field.message_type();
    if (is_new && inner != nullptr && inner->file()->package() == "haptic.v1") {
      add_fields(*inner, all);
    }
  }
}

void remove_given(const google::protobuf::Message& message, Fields& all) {
  std::vector<const google::protobuf::FieldDescriptor*> given;
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  reflection.ListFields(message, &given);
  for (const auto* field : given) {
    all.erase(field->full_name());
    if (field->message_type() == nullptr) continue;
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      remove_given(field->is_repeated() ? reflection.GetRepeatedMessage(message, field, i)
                                        : reflection.GetMessage(message, field),
                   all);
    }
  }
}

TEST(SceneFragments, EveryFieldStandsInAScene) {
  Fields missing;
  add_fields(*v1::Scene::descriptor(), missing);
  EXPECT_GT(missing.size(), 200u);
  for (const fs::path& folder : {kScenes, kScenes / "fragments"}) {
    for (const fs::path& file : scenes_in(folder)) {
      if (file.stem().extension() == ".calibration") continue;
      v1::Scene scene;
      ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(file_text(file), &scene)) << file;
      remove_given(scene, missing);
    }
  }
  EXPECT_THAT(missing, testing::IsEmpty());
}

const fs::path kSource = HAPTIC_SOURCE_DIR;

/// A folder like that of an installed hapticd.
class Installed : public testing::Test {
 protected:
  Installed() {
    fs::create_directories(prefix_ / "bin");
    fs::create_directories(prefix_ / "share/haptic");
    fs::copy(kScenes, prefix_ / "share/haptic/scenes");
    fs::copy("/bin/true", prefix_ / "bin/hapticd");
  }
  const ScratchFolder folder_{};
  const fs::path& prefix_ = folder_.path();
};

TEST_F(Installed, AProgramFindsItsShareDirectory) {
  EXPECT_EQ(server::shipped_scenes_folder(prefix_ / "bin/hapticd"),
            prefix_ / "share/haptic/scenes");
  EXPECT_EQ(server::shipped_scenes_folder(prefix_ / "bin/none"), "");
}

TEST(ShippedScenesByName, ABuildTreeFindsTheSources) {
  EXPECT_TRUE(fs::equivalent(server::shipped_scenes_folder(kSource / "README.md"), kScenes));
}

TEST(ShippedScenesByName, EachHasOneSentence) {
  const auto scenes = server::shipped_scenes(kScenes);
  EXPECT_GE(scenes.size(), 17u);
  for (const server::ShippedScene& scene : scenes) {
    EXPECT_TRUE(scene.summary.size() > 20 && scene.summary.size() < 90) << scene.summary;
    EXPECT_EQ(scene.summary.back(), '.') << scene.summary;
  }
}

TEST(ShippedScenesByName, OnlyNamesAreFound) {
  EXPECT_EQ(server::find_scene("finger_constant", kScenes), kScenes / "finger_constant.textproto");
  for (const char* name : {"finger_constan", "", "../scenes/finger_constant", "motion"}) {
    EXPECT_EQ(server::find_scene(name, kScenes), std::nullopt) << name;
  }
  EXPECT_EQ(server::find_scene("finger_constant", ""), std::nullopt);
}

TEST(ShippedScenesByName, TheLikestIsMeant) {
  EXPECT_EQ(server::scene_like("finger_soft_gras", kScenes), "finger_soft_grasp");
  EXPECT_EQ(server::scene_like("finger_softgrasp", kScenes), "finger_soft_grasp");
  EXPECT_EQ(server::scene_like("fnger-constatn", kScenes), "finger_constant");
  for (const char* name : {"", "x", "none", "my_own_glove"}) {
    EXPECT_EQ(server::scene_like(name, kScenes), "") << name;
  }
}

}  // namespace
}  // namespace haptic::test
