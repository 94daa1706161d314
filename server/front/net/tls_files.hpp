#pragma once
/// The contents of the files that a scene names for TLS.

#include <ctime>
#include <span>
#include <string>
#include <vector>

#include "server/base/descriptor.hpp"
#include "server/crossing/tls_config.hpp"

namespace haptic::server {

/// The end of a certificate's time.
struct CertificateEnd {
  std::string name{};  ///< "server.tls.certificate = 'server.pem'"
  std::time_t at{0};
};

/// PEM text. Never to be logged.
struct TlsFiles {
  std::string certificate{};
  std::string key{};
  std::string client_ca{};  ///< empty: clients need no certificate
  std::vector<CertificateEnd> ends{};
};

/// Reads and checks the files, which FrontStart has in this order: PEM, in date, and the key that
/// of the certificate. Throws core::TransportError with the field, the file and what is wrong, but
/// never with what a file holds.
[[nodiscard]] TlsFiles read_tls(const TlsConfig& config, std::span<const Descriptor> opened);

/// A sentence for each certificate that has ended, or ends within 14 days, with its date.
[[nodiscard]] std::vector<std::string> ending(const std::vector<CertificateEnd>& ends,
                                              std::time_t now);

}  // namespace haptic::server
