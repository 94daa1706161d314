#pragma once
/// The port of an address as a number, and a UDP socket as the owner binds it for a front.

#include <cstdint>
#include <string>
#include <utility>

#include "server/owner/link/listeners.hpp"

namespace haptic::test {

inline std::uint16_t port_of(const std::string& address) {
  return static_cast<std::uint16_t>(std::stoi(server::port_of(address)));
}

/// Throws core::TransportError naming `address`.
inline server::Descriptor bound_udp(const std::string& address) {
  const server::Listeners listeners({.listen = {"127.0.0.1:0"}, .udp_listen = address}, false);
  return std::move(listeners.sockets().back());
}

}  // namespace haptic::test
