// Finding the scenes that come with hapticd by name.
#include "server/scene/shipped.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

namespace haptic::test {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = HAPTIC_SOURCE_DIR;

/// A folder like that of an installed hapticd, gone at the end.
class Installed : public testing::Test {
 protected:
  Installed() {
    fs::create_directories(prefix_ / "bin");
    fs::create_directories(prefix_ / "share/haptic");
    fs::copy(kSource / "server/scenes", prefix_ / "share/haptic/scenes");
    fs::copy("/bin/true", prefix_ / "bin/hapticd");
  }
  ~Installed() override { fs::remove_all(prefix_); }
  const fs::path prefix_ =
      fs::canonical(fs::temp_directory_path()) / ("installed-scenes-" + std::to_string(::getpid()));
};

TEST_F(Installed, AProgramFindsItsShareDirectory) {
  EXPECT_EQ(server::shipped_scenes_folder(prefix_ / "bin/hapticd"),
            prefix_ / "share/haptic/scenes");
  EXPECT_EQ(server::shipped_scenes_folder(prefix_ / "bin/none"), "");
}

TEST(ShippedScenesByName, ABuildTreeFindsTheSources) {
  EXPECT_TRUE(fs::equivalent(server::shipped_scenes_folder(kSource / "README.md"),
                             kSource / "server/scenes"));
}

TEST(ShippedScenesByName, EachHasOneSentence) {
  const auto scenes = server::shipped_scenes(kSource / "server/scenes");
  EXPECT_GE(scenes.size(), 17u);
  for (const server::ShippedScene& scene : scenes) {
    EXPECT_TRUE(scene.summary.size() > 20 && scene.summary.size() < 90) << scene.summary;
    EXPECT_EQ(scene.summary.back(), '.') << scene.summary;
  }
}

TEST(ShippedScenesByName, ANameIsFoundAPathIsNot) {
  const fs::path folder = kSource / "server/scenes";
  EXPECT_EQ(server::find_scene("finger_constant", folder), folder / "finger_constant.textproto");
  for (const char* name : {"finger_constan", "", "../scenes/finger_constant", "motion"}) {
    EXPECT_EQ(server::find_scene(name, folder), std::nullopt) << name;
  }
  EXPECT_EQ(server::find_scene("finger_constant", ""), std::nullopt);
}

}  // namespace
}  // namespace haptic::test
