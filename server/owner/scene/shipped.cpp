#include "server/owner/scene/shipped.hpp"

#include <algorithm>
#include <fstream>
#include <numeric>

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

/// Number of letters to add, leave out or replace (V. I. Levenshtein, 1966).
std::size_t changes_between(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (const char letter : a) {
    std::size_t corner = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = corner + (letter == b[j] ? 0 : 1);
      corner = row[j + 1];
      row[j + 1] = std::min({replaced, corner + 1, row[j] + 1});
    }
  }
  return row.back();
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

std::string scene_like(const std::string& name, const fs::path& folder) {
  std::string nearest;
  std::size_t least = name.size() / 3 + 1;
  for (const ShippedScene& scene : shipped_scenes(folder)) {
    const std::size_t changes = changes_between(name, scene.name);
    if (changes >= least) continue;
    least = changes;
    nearest = scene.name;
  }
  return nearest;
}

std::optional<fs::path> find_scene(const std::string& name, const fs::path& folder) {
  const fs::path file = folder / (name + kExtension);
  std::error_code error;
  if (name.find('/') != std::string::npos || !fs::is_regular_file(file, error)) return std::nullopt;
  return file;
}

}  // namespace haptic::server
