#pragma once
/// TLS of a scene: the files, and what the bearers of client certificates may do.

#include <filesystem>
#include <string>
#include <vector>

#include "server/crossing/priority.hpp"

namespace haptic::server {

struct TlsClient {
  std::string name{};  ///< in its certificate
  Priority highest{Priority::kPrimary};
};

/// PEM files.
struct TlsConfig {
  std::filesystem::path certificate{};  ///< the server's, then those of its issuers
  std::filesystem::path key{};
  std::filesystem::path client_ca{};  ///< empty: clients need no certificate
  std::vector<TlsClient> clients{};   ///< others have kPrimary
};

}  // namespace haptic::server
