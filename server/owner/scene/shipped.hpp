#pragma once
/// The scenes that come with hapticd, found by their name.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace haptic::server {

struct ShippedScene {
  std::string name{};     ///< of its file, without ".textproto": "finger_constant"
  std::string summary{};  ///< the first sentence of its first comment
};

/// The folder of the scenes that belong to `program`: share/haptic/scenes next to the bin/ of an
/// installed one, server/scenes of the source tree around one in a build tree. Empty path: none.
/// Default: the running program.
[[nodiscard]] std::filesystem::path shipped_scenes_folder(
    const std::filesystem::path& program = "/proc/self/exe");

/// Every scene in `folder`, ordered by name; empty if there is no such folder.
[[nodiscard]] std::vector<ShippedScene> shipped_scenes(
    const std::filesystem::path& folder = shipped_scenes_folder());

/// The file of the shipped scene `name`; nothing if there is none, or if `name` is a path.
[[nodiscard]] std::optional<std::filesystem::path> find_scene(
    const std::string& name, const std::filesystem::path& folder = shipped_scenes_folder());

/// The name of the shipped scene that `name` was probably meant to be; empty: none is like it.
[[nodiscard]] std::string scene_like(const std::string& name,
                                     const std::filesystem::path& folder = shipped_scenes_folder());

}  // namespace haptic::server
