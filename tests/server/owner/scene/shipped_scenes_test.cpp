#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <typeinfo>

#include "haptic/v1/scene.pb.h"
#include "hw/board/board_device.hpp"
#include "server/owner/scene/shipped.hpp"
#include "tests/server/owner/scene/scene_text.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::test {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> scenes_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".textproto") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

void expect_same(const core::RenderSettings& a, const core::RenderSettings& b) {
  EXPECT_EQ(a.renderer, b.renderer);
  EXPECT_EQ(a.direction_guard, b.direction_guard);
  EXPECT_EQ(a.stiffness, b.stiffness);
  EXPECT_EQ(a.damping, b.damping);
  EXPECT_EQ(a.force_limit, b.force_limit);
  EXPECT_EQ(a.slew_limit, b.slew_limit);
  EXPECT_EQ(a.engage_window, b.engage_window);
  EXPECT_EQ(a.staleness, b.staleness);
}

void expect_same(const std::shared_ptr<const core::StiffnessCoupling>& a,
                 const std::shared_ptr<const core::StiffnessCoupling>& b) {
  ASSERT_EQ(a == nullptr, b == nullptr);
  if (a) {
    EXPECT_EQ(a->matrix(a->scene_stiffness()), b->matrix(b->scene_stiffness()));
  }
}

TEST(ShippedScenes, OpenTheirDevices) {
  const auto files = scenes_in(kScenes);
  EXPECT_GE(files.size(), 8u);
  for (const auto& file : files) {
    SCOPED_TRACE(file.filename());
    const server::Scene scene = server::load_scene(file);
    for (const server::DeviceScene& device : scene.devices) {
      if (device.source->is_hardware()) continue;
      const auto opened = device.source->open(device.pipeline.kinematics, {});
      ASSERT_NE(opened, nullptr);
      EXPECT_EQ(opened->info().limits.max_effort.size(), device.pipeline.scene.force_limit.size());
    }
  }
}

TEST(ShippedScenes, ResolvedTextReadsBackTheSame) {
  for (const auto& file : scenes_in(kScenes)) {
    SCOPED_TRACE(file.filename());
    const server::Scene scene = server::load_scene(file);
    const server::Scene again = server::parse_scene(scene.resolved, "resolved", "/");
    EXPECT_EQ(again.resolved, scene.resolved);
    EXPECT_EQ(again.name, scene.name);
    EXPECT_EQ(again.server.listen, scene.server.listen);
    EXPECT_EQ(again.loop.period, scene.loop.period);
    EXPECT_EQ(again.loop.loop_late_fault, scene.loop.loop_late_fault);
    EXPECT_EQ(again.record.has_value(), scene.record.has_value());
    ASSERT_EQ(again.devices.size(), scene.devices.size());
    for (std::size_t i = 0; i < scene.devices.size(); ++i) {
      EXPECT_EQ(again.devices[i].name, scene.devices[i].name);
      EXPECT_EQ(again.devices[i].fresh_end, scene.devices[i].fresh_end);
      const hw::DeviceConfig &a = *again.devices[i].source, &b = *scene.devices[i].source;
      EXPECT_EQ(typeid(a), typeid(b));
      expect_same(again.devices[i].pipeline.scene, scene.devices[i].pipeline.scene);
      expect_same(again.devices[i].pipeline.projection.coupling,
                  scene.devices[i].pipeline.projection.coupling);
    }
  }
}

TEST(ShippedScenes, HaveGuardAndTank) {
  for (const auto& file : scenes_in(kScenes)) {
    for (const server::DeviceScene& device : server::load_scene(file).devices) {
      EXPECT_TRUE(device.pipeline.scene.direction_guard) << file.filename();
      EXPECT_TRUE(device.pipeline.passivity.tank.enabled) << file.filename();
    }
  }
}

TEST(ShippedScenes, WarnOfNothing) {
  for (const auto& file : scenes_in(kScenes)) {
    for (const std::string& warning : server::load_scene(file).warnings) {
      ADD_FAILURE() << file.filename() << ": " << warning;
    }
  }
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
      std::ostringstream text;
      text << std::ifstream(file).rdbuf();
      v1::Scene scene;
      ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(text.str(), &scene)) << file;
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

}  // namespace
}  // namespace haptic::test
