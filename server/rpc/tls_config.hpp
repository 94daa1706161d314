#pragma once
/// What is needed to serve TLS: files, and what the bearers of client certificates may do.

#include <filesystem>
#include <string>
#include <vector>

#include "server/session/priority.hpp"

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

/// The files' contents. Never to be logged.
struct TlsFiles {
  std::string certificate{};
  std::string key{};
  std::string client_ca{};
};

/// Reads and checks them: readable, PEM, the key that of the certificate, in date. Throws
/// TransportError naming field, file and what is wrong; never what a file holds.
[[nodiscard]] TlsFiles load_tls(const TlsConfig& config);

}  // namespace haptic::server
