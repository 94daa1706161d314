#include "doctor/host_files.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>

namespace haptic::ctl {

std::filesystem::path HostFiles::under_root(const std::string& path) const {
  return root_ / std::filesystem::path(path).relative_path();
}

std::optional<std::string> HostFiles::text(const std::string& path) const {
  std::ifstream stream(under_root(path));
  if (!stream) return std::nullopt;
  std::ostringstream all;
  all << stream.rdbuf();
  std::string text = all.str();
  while (!text.empty() && (text.back() == '\n' || text.back() == '\0')) text.pop_back();
  return text;
}

std::optional<long long> HostFiles::number(const std::string& path) const {
  const auto found = text(path);
  if (!found) return std::nullopt;
  long long value = 0;
  const auto result = std::from_chars(found->data(), found->data() + found->size(), value);
  if (result.ec != std::errc{}) return std::nullopt;
  return value;
}

std::vector<std::string> HostFiles::entries(const std::string& folder,
                                            const std::string& prefix) const {
  std::vector<std::string> found;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(under_root(folder), error)) {
    const std::filesystem::path name = entry.path().filename();
    if (name.string().rfind(prefix, 0) == 0)
      found.push_back((std::filesystem::path(folder) / name).string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace haptic::ctl
