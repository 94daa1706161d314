#pragma once
/// A whole file as text.

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace haptic::test {

/// Empty if there is none.
inline std::string file_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace haptic::test
