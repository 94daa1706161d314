#pragma once
/// Form of an address and what protects it, for the process that binds it and the one that
/// serves it.

#include <cstdint>
#include <string>

namespace haptic::server {

/// The protection of an address.
enum class Protection : std::uint8_t {
  kThisHost,     ///< plain text that does not leave this host: a UNIX socket, or loopback
  kTls,          ///< every client that reaches it is served
  kMutualTls,    ///< clients show a certificate
  kInsecureLab,  ///< plain text on a network, by --insecure-lab
};

/// The parts of "host:port", "[v6]:port".
[[nodiscard]] inline std::string host_of(const std::string& address) {
  return address.substr(0, address.rfind(':'));
}
[[nodiscard]] inline std::string port_of(const std::string& address) {
  return address.substr(address.rfind(':') + 1);
}

/// A literal address of loopback, or "localhost": any other name may resolve to anywhere.
[[nodiscard]] bool is_loopback(const std::string& host);

/// The path of "unix:/path", or of "unix:///path", the same with a scheme's slashes; else empty.
[[nodiscard]] std::string unix_path(const std::string& address);

}  // namespace haptic::server
