#pragma once
/// The contents of the files that a scene names for TLS.

#include <string>

#include "server/crossing/tls_config.hpp"

namespace haptic::server {

/// PEM text. Never to be logged.
struct TlsFiles {
  std::string certificate{};
  std::string key{};
  std::string client_ca{};
};

/// Reads and checks the files: readable, PEM, in date, and the key that of the certificate. Throws
/// TransportError with the field, the file and what is wrong, never with what a file holds.
[[nodiscard]] TlsFiles load_tls(const TlsConfig& config);

}  // namespace haptic::server
