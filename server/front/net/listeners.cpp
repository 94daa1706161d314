#include "server/front/net/listeners.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "haptic/core/error.hpp"
#include "server/front/net/listen_address.hpp"

namespace haptic::server {
namespace {

[[noreturn]] void cannot_bind(const std::string& address, const std::string& why) {
  throw core::TransportError("listen address '" + address + "': cannot be bound: " + why);
}

/// Empty, with errno set: it cannot be bound.
Descriptor bound(const sockaddr* name, socklen_t size) {
  Descriptor listener(socket(name->sa_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!listener) return listener;
  if (name->sa_family != AF_UNIX) {
    // A server that starts again takes its port back; never a port that another one serves.
    const int on = 1;
    setsockopt(listener.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  }
  if (name->sa_family == AF_INET6) {
    // [::] serves IPv4 too; every other address is one of IPv6 alone.
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(*name);
    const int only = IN6_IS_ADDR_UNSPECIFIED(&v6.sin6_addr) ? 0 : 1;
    setsockopt(listener.get(), IPPROTO_IPV6, IPV6_V6ONLY, &only, sizeof only);
  }
  if (bind(listener.get(), name, size) != 0 || listen(listener.get(), SOMAXCONN) != 0) return {};
  return listener;
}

}  // namespace

Listeners::Listeners(const std::vector<std::string>& addresses) {
  for (std::size_t i = 0; i < addresses.size(); ++i) {
    const std::string path = unix_path(addresses[i]);
    path.empty() ? listen_tcp(i, addresses[i]) : listen_unix(i, addresses[i], path);
  }
}

Listeners::~Listeners() {
  for (const File& file : files_) {
    struct stat now {};
    const bool same =
        stat(file.path.c_str(), &now) == 0 && now.st_dev == file.device && now.st_ino == file.inode;
    if (same) unlink(file.path.c_str());
  }
}

void Listeners::listen_unix(std::size_t index, const std::string& address,
                            const std::string& path) {
  File file{path};
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  file.path.copy(name.sun_path, sizeof name.sun_path - 1);
  unlink(file.path.c_str());  // no process answers there: check_listen_address()
  Descriptor listener = bound(reinterpret_cast<const sockaddr*>(&name), sizeof name);
  if (!listener) cannot_bind(address, std::strerror(errno));
  struct stat made {};
  if (stat(file.path.c_str(), &made) == 0) {
    file.device = made.st_dev;
    file.inode = made.st_ino;
    files_.push_back(std::move(file));
  }
  sockets_.push_back({std::move(listener), index});
  ports_.push_back(0);
}

void Listeners::listen_tcp(std::size_t index, const std::string& address) {
  const std::size_t colon = address.rfind(':');
  std::string host = address.substr(0, colon);
  if (host.front() == '[') host = host.substr(1, host.size() - 2);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* first = nullptr;
  const int error = getaddrinfo(host.c_str(), address.substr(colon + 1).c_str(), &hints, &first);
  if (error != 0) cannot_bind(address, gai_strerror(error));
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> all(first, &freeaddrinfo);
  int port = 0;
  int failed = 0;
  for (const addrinfo* each = first; each != nullptr; each = each->ai_next) {
    // The port lies at the same place in sockaddr_in and sockaddr_in6. If any port will do, the
    // sockets of one name share the one that the first of them got.
    auto& name = *reinterpret_cast<sockaddr_in*>(each->ai_addr);
    if (port != 0) name.sin_port = htons(static_cast<std::uint16_t>(port));
    Descriptor listener = bound(each->ai_addr, each->ai_addrlen);
    if (!listener) {
      failed = errno;
      // localhost has an address of IPv6 on hosts that have no IPv6.
      if (failed != EADDRNOTAVAIL && failed != EAFNOSUPPORT)
        cannot_bind(address, std::strerror(failed));
      continue;
    }
    sockaddr_storage got{};
    socklen_t size = sizeof got;
    getsockname(listener.get(), reinterpret_cast<sockaddr*>(&got), &size);
    port = ntohs(reinterpret_cast<const sockaddr_in&>(got).sin_port);
    sockets_.push_back({std::move(listener), index});
  }
  if (port == 0) cannot_bind(address, std::strerror(failed));
  ports_.push_back(port);
}

}  // namespace haptic::server
