#pragma once
/// Content that is served over HTTP besides the service: the page's files, and the metrics' text.

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

namespace haptic::server {

struct PageFile {
  std::string type{};  ///< "text/html; charset=utf-8"
  std::string_view bytes{};
  std::shared_ptr<void> memory{};  ///< which holds them, apart from the heap
};
/// Files by the path of their address, "/app.js"; "/" is index.html.
using Page = std::map<std::string, PageFile, std::less<>>;

/// Text that hapticd serves if `Page` has no "/".
constexpr std::string_view kNoPage =
    "The page was not built (needs npm): cmake --build build/release --target haptic_page";

struct WebContent {
  Page page{};
  std::function<std::string()> metrics{};  ///< called for every scrape; empty: there are none
};

/// The files of `folder` and of the folders in it; none if it does not exist. Throws
/// core::TransportError that names what this process's user cannot read, or if all together have
/// more than 24 MB. A link, as /proc has them, is called by the name of what it leads to.
[[nodiscard]] Page load_page(const std::filesystem::path& folder);

}  // namespace haptic::server
