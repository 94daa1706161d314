#pragma once
/// Creates the file of a recording. What was recorded before stays, unless the scene says
/// otherwise; a file that another process still writes is never touched, and no symbolic link is
/// followed.

#include <filesystem>

namespace haptic::server {

struct NewFile {
  std::filesystem::path path{};  ///< the name that it got
  int descriptor{-1};            ///< open for writing and locked (flock); the holder closes it
};

/// If there is a file of the wanted name it stays, and the new one gets the next free name:
/// run-2.csv, run-3.csv, ...; with `overwrite` it is emptied instead. Throws SceneError with path
/// and reason: no such folder, no permission, the name belongs to something that is no regular
/// file, or another process writes the file that is to be overwritten.
[[nodiscard]] NewFile create_file(const std::filesystem::path& wanted, bool overwrite);

/// Throws SceneError if create_file() would, as far as that can be told without creating anything.
void check_creatable(const std::filesystem::path& wanted, bool overwrite);

}  // namespace haptic::server
