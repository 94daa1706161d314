#pragma once
/// Browsers and other clients that speak HTTP, in a scene.

#include <filesystem>
#include <string>
#include <vector>

#include "server/crossing/priority.hpp"

namespace haptic::server {

/// Rights of a token, besides a stop.
struct WebRights {
  bool control{false};                ///< false: it may look on
  Priority highest{Priority::kTest};  ///< with control
};

struct WebToken {
  std::string name{};            ///< of who shows it
  std::filesystem::path file{};  ///< holds it on one line
  WebRights rights{};
};

struct WebConfig {
  std::vector<std::string> listen{};  ///< as ServerScene::listen
  std::vector<std::string> names{};   ///< further Hosts, without a port
  std::vector<std::string> origins{};
  std::vector<WebToken> tokens{};
  WebRights printed{};  ///< of the one-time address that hapticd prints
};

}  // namespace haptic::server
