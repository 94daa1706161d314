#include "server/owner/scene/shipped.hpp"

#include <algorithm>
#include <fstream>

namespace haptic::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".textproto";

/// The first sentence of the first comment that is not a `# proto-...` line of textproto itself.
std::string summary_of(const fs::path& file) {
  std::ifstream stream(file);
  std::string text;
  for (std::string line; std::getline(stream, line) && line.rfind('#', 0) == 0;) {
    if (line.rfind("# proto-", 0) == 0 || line.size() < 3) continue;
    text += (text.empty() ? "" : " ") + line.substr(2);
    if (const std::size_t end = (text + " ").find(". "); end != std::string::npos) {
      return text.substr(0, end + 1);
    }
  }
  return text;
}

}  // namespace

fs::path shipped_scenes_folder(const fs::path& program) {
  std::error_code error;
  const fs::path file = fs::canonical(program, error);
  for (fs::path around = file.parent_path(); around.has_relative_path();
       around = around.parent_path()) {
    for (const char* place : {"share/haptic/scenes", "server/scenes"}) {
      if (fs::is_directory(around / place, error)) return around / place;
    }
  }
  return {};
}

std::vector<ShippedScene> shipped_scenes(const fs::path& folder) {
  std::vector<ShippedScene> scenes;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() != kExtension) continue;
    scenes.push_back({entry.path().stem().string(), summary_of(entry.path())});
  }
  std::sort(scenes.begin(), scenes.end(),
            [](const ShippedScene& a, const ShippedScene& b) { return a.name < b.name; });
  return scenes;
}

std::optional<fs::path> find_scene(const std::string& name, const fs::path& folder) {
  const fs::path file = folder / (name + kExtension);
  std::error_code error;
  if (name.find('/') != std::string::npos || !fs::is_regular_file(file, error)) return std::nullopt;
  return file;
}

}  // namespace haptic::server
