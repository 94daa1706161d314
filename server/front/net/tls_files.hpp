#pragma once
/// The contents of the files that a scene names for TLS.

#include <span>
#include <string>

#include "server/base/descriptor.hpp"
#include "server/crossing/tls_config.hpp"

namespace haptic::server {

/// PEM text. Never to be logged.
struct TlsFiles {
  std::string certificate{};
  std::string key{};
  std::string client_ca{};  ///< empty: clients need no certificate
};

/// Reads and checks the files, which FrontStart has in this order: PEM, in date, and the key that
/// of the certificate. Throws core::TransportError with the field, the file and what is wrong, but
/// never with what a file holds.
[[nodiscard]] TlsFiles read_tls(const TlsConfig& config, std::span<const Descriptor> opened);

}  // namespace haptic::server
