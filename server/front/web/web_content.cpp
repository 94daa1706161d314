#include "server/front/web/web_content.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <new>
#include <utility>

#include "haptic/core/error.hpp"

namespace haptic::server {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargest = 24u << 20;

/// Not on the heap, whose growth says that somebody attacks (net/connections.hpp).
std::shared_ptr<void> allocate(std::size_t bytes) {
  void* const memory = ::mmap(nullptr, std::max<std::size_t>(bytes, 1), PROT_READ | PROT_WRITE,
                              MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  return {memory, [bytes](void* all) { ::munmap(all, std::max<std::size_t>(bytes, 1)); }};
}

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
  std::error_code why;
  const fs::path leads_to = fs::read_symlink(folder, why);
  const fs::path name = why ? folder : leads_to;
  const auto unreadable = [](const fs::path& what) {
    return core::TransportError("page: '" + what.string() + "' cannot be read by user " +
                                std::to_string(geteuid()));
  };
  fs::recursive_directory_iterator entries(folder, why);
  if (why == std::errc::permission_denied) throw unreadable(name);
  std::size_t bytes = 0;
  for (const fs::directory_entry& entry : entries) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const fs::path relative = entry.path().lexically_relative(folder);
    const std::size_t size = entry.file_size(why);
    if (!file || why) throw unreadable(name / relative);
    bytes += size;
    if (bytes > kLargest) {
      throw core::TransportError("page: '" + name.string() + "' has more than 24 MB");
    }
    PageFile content{type_of(entry.path()), {}, allocate(size)};
    auto* const memory = static_cast<char*>(content.memory.get());
    if (!file.read(memory, static_cast<std::streamsize>(size))) {
      throw unreadable(name / relative);
    }
    content.bytes = {memory, size};
    page.emplace("/" + relative.generic_string(), std::move(content));
  }
  if (const auto index = page.find("/index.html"); index != page.end()) {
    page.emplace("/", index->second);
  }
  return page;
}

}  // namespace haptic::server
