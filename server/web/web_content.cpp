#include "server/web/web_content.hpp"

#include <fstream>
#include <iterator>
#include <utility>

#include "haptic/core/error.hpp"

namespace haptic::server {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargest = 8u << 20;

const char* type_of(const fs::path& file) {
  static constexpr std::pair<const char*, const char*> kTypes[] = {
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".mjs", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
      {".wasm", "application/wasm"},
      {".json", "application/json"},
      {".webmanifest", "application/manifest+json"},
      {".xml", "text/xml; charset=utf-8"},
      {".txt", "text/plain; charset=utf-8"}};
  for (const auto& [ending, type] : kTypes) {
    if (file.extension() == ending) return type;
  }
  return "application/octet-stream";
}

}  // namespace

Page load_page(const fs::path& folder) {
  Page page;
  std::error_code none;
  std::size_t bytes = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder, none)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    PageFile content{type_of(entry.path()), {std::istreambuf_iterator<char>(file), {}}};
    if (!file) throw core::TransportError("page: '" + entry.path().string() + "' cannot be read");
    bytes += content.bytes.size();
    if (bytes > kLargest) {
      throw core::TransportError("page: '" + folder.string() + "' has more than 8 MB");
    }
    page.emplace("/" + fs::relative(entry.path(), folder).generic_string(), std::move(content));
  }
  if (const auto index = page.find("/index.html"); index != page.end()) {
    page.emplace("/", index->second);
  }
  return page;
}

fs::path page_folder(const fs::path& program) {
  const fs::path folder = program.parent_path();
  if (fs::path built = folder / "page" / "dist"; fs::is_directory(built)) return built;
  // PREFIX/libexec/hapticd/hapticd-front, or PREFIX/bin/hapticd-front.
  const bool libexec = folder.parent_path().filename() == "libexec";
  const fs::path prefix = libexec ? folder.parent_path().parent_path() : folder.parent_path();
  return prefix / "share" / "haptic" / "page";
}

}  // namespace haptic::server
