#pragma once
/// A folder, and a file in one, that go with the test.

#include <stdlib.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

namespace haptic::test {

/// Empty at first.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name =
        std::filesystem::canonical(std::filesystem::temp_directory_path()) / "haptic-test-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) {
      throw std::system_error(errno, std::generic_category(), name);
    }
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

class TemporaryFile {
 public:
  explicit TemporaryFile(std::string_view text = {}, const std::string& name = "motion.csv")
      : path_(folder_.path() / name) {
    write(text);
  }
  void write(std::string_view text) const { std::ofstream(path_, std::ios::binary) << text; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  ScratchFolder folder_{};
  std::filesystem::path path_;
};

}  // namespace haptic::test
