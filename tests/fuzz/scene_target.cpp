#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "haptic/core/error.hpp"
#include "server/owner/scene/scene.hpp"
#include "tests/fuzz/targets.hpp"

namespace haptic::test {
namespace {

const std::filesystem::path kScenes =
    std::filesystem::path(HAPTIC_SOURCE_DIR) / "server" / "scenes";

std::string run(FuzzInput input) {
  const std::string text(input.begin(), input.end());
  std::string resolved;
  try {
    resolved = server::parse_scene(text, "fuzz", kScenes).resolved;
  } catch (const core::SceneError& error) {
    return *error.what() == '\0' ? "an error without a word" : "";
  } catch (const std::exception& error) {
    return std::string("another exception than SceneError: ") + error.what();
  }
  try {
    if (server::parse_scene(resolved, "fuzz", kScenes).resolved != resolved) {
      return "the resolved scene does not read back as itself";
    }
  } catch (const std::exception& error) {
    return std::string("the resolved scene does not read back: ") + error.what();
  }
  return {};
}

std::vector<FuzzBytes> scene_seeds() {
  std::vector<FuzzBytes> seeds;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kScenes)) {
    if (entry.path().extension() != ".textproto") continue;
    std::ifstream stream(entry.path());
    std::stringstream whole;
    whole << stream.rdbuf();
    const std::string text = whole.str();
    seeds.emplace_back(text.begin(), text.end());
  }
  std::sort(seeds.begin(), seeds.end());
  return seeds;
}

}  // namespace

const FuzzTarget& scene_target() {
  static const FuzzTarget kTarget{"scene", run, scene_seeds, 16384};
  return kTarget;
}

}  // namespace haptic::test
