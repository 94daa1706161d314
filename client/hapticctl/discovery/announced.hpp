#pragma once
/// Reads the output of avahi-browse: the servers that announce themselves by DNS-SD (hapticctl
/// find).

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace haptic::ctl {

/// Bytes of any host of the network: neither true nor printable before somebody has looked.
struct Announced {
  std::string name{};              ///< of the service, at most 63 bytes by DNS-SD
  std::string host{};              ///< "lab.local": what a certificate may name
  std::string address{};           ///< for --server: "192.0.2.7:PORT", "[fe80::1%eth0]:PORT"
  std::vector<std::string> txt{};  ///< "protocol=haptic.v1"

  auto operator<=>(const Announced&) const = default;
};

/// One line of `avahi-browse --resolve --parsable`. Absent if it is not a resolved service with an
/// IP address and a port from 1 to 65535.
[[nodiscard]] std::optional<Announced> announced(std::string_view line);

}  // namespace haptic::ctl
