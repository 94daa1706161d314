#include "server/front/net/peer_name.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>

namespace haptic::server {
namespace {

std::string text_of(int family, const void* address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  inet_ntop(family, address, text.data(), text.size());
  return text.data();
}

PeerName of_v4(const void* address, in_port_t port) {
  const std::string text = text_of(AF_INET, address);
  return {"ipv4:" + text + ":" + std::to_string(ntohs(port)), text};
}

PeerName of_v6(const sockaddr_in6& peer) {
  if (IN6_IS_ADDR_V4MAPPED(&peer.sin6_addr)) {
    return of_v4(&peer.sin6_addr.s6_addr[12], peer.sin6_port);
  }
  in6_addr network = peer.sin6_addr;
  // A host may have every address of its /64. This host has one address, and no network.
  if (!IN6_IS_ADDR_LOOPBACK(&network)) std::fill_n(&network.s6_addr[8], 8, std::uint8_t{0});
  // A link-local address has its scope in gRPC's name, escaped.
  const std::string scope =
      peer.sin6_scope_id == 0 ? "" : "%25" + std::to_string(peer.sin6_scope_id);
  return {"ipv6:%5B" + text_of(AF_INET6, &peer.sin6_addr) + scope +
              "%5D:" + std::to_string(ntohs(peer.sin6_port)),
          text_of(AF_INET6, &network)};
}

}  // namespace

PeerName peer_name(int socket) {
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  if (getpeername(socket, reinterpret_cast<sockaddr*>(&peer), &size) != 0) return {};
  if (peer.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(peer);
    return of_v4(&v4.sin_addr, v4.sin_port);
  }
  if (peer.ss_family == AF_INET6) return of_v6(reinterpret_cast<const sockaddr_in6&>(peer));
  ucred user{};
  size = sizeof user;
  getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &user, &size);
  return {{}, "user " + std::to_string(user.uid)};
}

}  // namespace haptic::server
