#include "server/crossing/listen_address.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <string_view>

namespace haptic::server {

bool is_loopback(const std::string& host) {
  if (host == "localhost" || host == "[::1]") return true;
  in_addr address{};
  return ::inet_pton(AF_INET, host.c_str(), &address) == 1 &&
         (ntohl(address.s_addr) >> 24U) == IN_LOOPBACKNET;
}

std::string unix_path(const std::string& address) {
  constexpr std::string_view kUnix = "unix:";
  if (address.rfind(kUnix, 0) != 0) return {};
  const std::string path = address.substr(kUnix.size());
  return path.rfind("//", 0) == 0 ? path.substr(2) : path;
}

}  // namespace haptic::server
