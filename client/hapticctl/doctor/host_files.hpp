#pragma once
/// The files of /proc, /sys and /dev that the doctor reads, below a root folder: "/" on a host, a
/// folder of its own in a test.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace haptic::ctl {

class HostFiles {
 public:
  explicit HostFiles(std::filesystem::path root = "/") : root_(std::move(root)) {}

  /// The whole text without its last newlines; nothing if it cannot be read.
  [[nodiscard]] std::optional<std::string> text(const std::string& path) const;
  /// A whole number at the beginning of the file.
  [[nodiscard]] std::optional<long long> number(const std::string& path) const;
  /// Full paths of the entries of a folder whose names begin with `prefix`, sorted.
  [[nodiscard]] std::vector<std::string> entries(const std::string& folder,
                                                 const std::string& prefix) const;

 private:
  [[nodiscard]] std::filesystem::path under_root(const std::string& path) const;
  std::filesystem::path root_;
};

}  // namespace haptic::ctl
