#include "server/front/net/listen_address.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "haptic/core/error.hpp"

namespace haptic::server {
namespace {

constexpr char kUnix[] = "unix:";

bool is_unix(const std::string& address) {
  return address.rfind(kUnix, 0) == 0;
}

[[noreturn]] void refuse(const std::string& address, const std::string& why) {
  throw core::TransportError("listen address '" + address + "': " + why);
}

/// A process accepts connections there.
bool answers(const sockaddr_un& socket_address) {
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  const bool connected =
      ::connect(fd, reinterpret_cast<const sockaddr*>(&socket_address), sizeof socket_address) == 0;
  ::close(fd);
  return connected;
}

void check_unix(const std::string& address) {
  const std::string path = unix_path(address);
  sockaddr_un socket_address{};
  socket_address.sun_family = AF_UNIX;
  if (path.empty() || path.front() != '/') refuse(address, "must be unix:/absolute/path");
  if (path.size() >= sizeof socket_address.sun_path) {
    refuse(address, "the path has " + std::to_string(path.size()) + " bytes: at most " +
                        std::to_string(sizeof socket_address.sun_path - 1) + " are allowed");
  }
  std::memcpy(socket_address.sun_path, path.c_str(), path.size() + 1);
  struct stat existing {};
  if (::stat(path.c_str(), &existing) != 0) return;
  if (!S_ISSOCK(existing.st_mode)) refuse(address, "the path exists and is no socket");
  if (answers(socket_address)) refuse(address, "in use by another process");
}

/// The host.
std::string check_tcp(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0) {
    refuse(address, "must be host:port or unix:/path");
  }
  std::string host = address.substr(0, colon);
  const std::string port = address.substr(colon + 1);
  const bool digits =
      !port.empty() && port.size() <= 5 &&
      std::all_of(port.begin(), port.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!digits || std::stoi(port) > 65535) {
    refuse(address, "port '" + port + "': must be 0..65535");
  }
  return host;
}

}  // namespace

bool is_loopback(const std::string& host) {
  if (host == "localhost" || host == "[::1]") return true;
  in_addr address{};
  return ::inet_pton(AF_INET, host.c_str(), &address) == 1 &&
         (ntohl(address.s_addr) >> 24U) == IN_LOOPBACKNET;
}

std::string unix_path(const std::string& address) {
  if (!is_unix(address)) return {};
  const std::string path = address.substr(sizeof kUnix - 1);
  return path.rfind("//", 0) == 0 ? path.substr(2) : path;
}

Protection check_listen_address(const std::string& address, Protection best) {
  if (is_unix(address)) {
    check_unix(address);
    return Protection::kThisHost;
  }
  const std::string host = check_tcp(address);
  if (best == Protection::kTls || best == Protection::kMutualTls) return best;
  if (is_loopback(host)) return Protection::kThisHost;
  if (best == Protection::kInsecureLab) return best;
  refuse(address, "host '" + host +
                      "' is not loopback: without TLS only 127.0.0.0/8, [::1], localhost and "
                      "unix:/path are served; give the scene server.tls, or hapticd "
                      "--insecure-lab for plain text on a network that is yours alone");
}

const char* word(Protection protection) noexcept {
  static constexpr std::array kWords{"plain text, this host only", "TLS",
                                     "TLS, clients by certificate",
                                     "PLAIN TEXT, OPEN TO THE NETWORK"};
  return kWords[static_cast<std::size_t>(protection)];
}

std::string weakness(const std::string& address, Protection protection) {
  switch (protection) {
    case Protection::kThisHost:
      return is_unix(address)
                 ? "gRPC without TLS on " + address + ", open to every user who may open that file"
                 : "gRPC without TLS on " + address + ", open to every user of this host";
    case Protection::kTls:
      return "TLS without client certificates on " + address +
             ": every client that reaches it may take a device that is free, or that a client of a "
             "lower "
             "priority has (PRIORITY_PRIMARY at most)";
    case Protection::kMutualTls:
      return {};
    case Protection::kInsecureLab:
      break;
  }
  return "gRPC without TLS on " + address +
         " (--insecure-lab): every host on that network may read everything, the keys of the UDP "
         "path too, and move the device";
}

std::string with_port(const std::string& address, int port) {
  if (is_unix(address)) return address;
  return address.substr(0, address.rfind(':') + 1) + std::to_string(port);
}

}  // namespace haptic::server
