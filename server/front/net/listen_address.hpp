#pragma once
/// Addresses a server may listen on .

#include <cstdint>
#include <string>

namespace haptic::server {

/// Protection of an address.
enum class Protection : std::uint8_t {
  kThisHost,     ///< plain text that does not leave this host: a UNIX socket, or loopback
  kTls,          ///< every client that reaches it is served
  kMutualTls,    ///< clients show a certificate
  kInsecureLab,  ///< plain text on a network, by --insecure-lab
};

[[nodiscard]] constexpr bool encrypts(Protection protection) noexcept {
  return protection == Protection::kTls || protection == Protection::kMutualTls;
}

/// Throws TransportError naming the address: not "host:port" or "unix:/path"; a host other than
/// loopback with `best` kThisHost (plain text stays on this machine); a UNIX socket that another
/// process answers on (gRPC itself would take its path away silently), or a path that is too long
/// or no socket. Else what protects it; `best` is the best that the server can offer.
Protection check_listen_address(const std::string& address,
                                Protection best = Protection::kThisHost);

/// A literal address of loopback, or "localhost": any other name may resolve to anywhere.
[[nodiscard]] bool is_loopback(const std::string& host);

/// The path of "unix:/path", or of "unix:///path", the same with a scheme's slashes; else empty.
[[nodiscard]] std::string unix_path(const std::string& address);

/// "TLS", ...: for people.
[[nodiscard]] const char* word(Protection protection) noexcept;
/// Weakness of `address`, a sentence; empty: nothing.
[[nodiscard]] std::string weakness(const std::string& address, Protection protection);

/// `address` with the port that was bound in the place of its own.
[[nodiscard]] std::string with_port(const std::string& address, int port);

}  // namespace haptic::server
