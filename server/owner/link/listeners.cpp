#include "server/owner/link/listeners.hpp"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "haptic/core/error.hpp"

namespace haptic::server {
namespace {

using Use = FrontConfig::Use;

[[noreturn]] void refuse(const std::string& address, const std::string& why) {
  throw core::TransportError("listen address '" + address + "': " + why);
}

/// A process accepts connections there.
bool answers(const sockaddr_un& name) {
  const Descriptor caller(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  return connect(caller.get(), reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0;
}

sockaddr_un unix_name(const std::string& path) {
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  path.copy(name.sun_path, sizeof name.sun_path - 1);
  return name;
}

void check_unix(const std::string& address) {
  const std::string path = unix_path(address);
  struct stat existing {};
  if (stat(path.c_str(), &existing) != 0) return;
  if (!S_ISSOCK(existing.st_mode)) refuse(address, "the path exists and is no socket");
  if (answers(unix_name(path))) refuse(address, "in use by another process");
}

/// Empty, with errno set: it cannot be bound.
Descriptor bound(const sockaddr* name, socklen_t size, int type) {
  Descriptor made(socket(name->sa_family, type | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!made) return made;
  const bool listens = type == SOCK_STREAM;
  if (listens && name->sa_family != AF_UNIX) {
    // A server that starts again takes its port back; never a port that another one serves.
    const int on = 1;
    setsockopt(made.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  }
  if (name->sa_family == AF_INET6) {
    // [::] serves IPv4 too; every other address is one of IPv6 alone.
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(*name);
    const int only = IN6_IS_ADDR_UNSPECIFIED(&v6.sin6_addr) ? 0 : 1;
    setsockopt(made.get(), IPPROTO_IPV6, IPV6_V6ONLY, &only, sizeof only);
  }
  if (bind(made.get(), name, size) != 0) return {};
  if (listens && listen(made.get(), SOMAXCONN) != 0) return {};
  return made;
}

struct Addresses {
  std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> first{nullptr, &freeaddrinfo};
  int error{0};  ///< of getaddrinfo()
};

/// A UDP path has one socket: a literal address, or localhost for 127.0.0.1.
Addresses resolve(std::string host, const std::string& port, int type) {
  if (host.front() == '[') host = host.substr(1, host.size() - 2);
  if (type == SOCK_DGRAM && host == "localhost") host = "127.0.0.1";
  addrinfo hints{};
  hints.ai_socktype = type;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV | (type == SOCK_DGRAM ? AI_NUMERICHOST : 0);
  addrinfo* first = nullptr;
  const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &first);
  return {{first, &freeaddrinfo}, error};
}

/// The best protection of an address. For browsers a token takes the place of a certificate, and
/// metrics are never encrypted.
Protection best_protection(const ServerScene& scene, bool insecure_lab, Use use) {
  if (!scene.tls || use == Use::kMetrics) {
    return insecure_lab ? Protection::kInsecureLab : Protection::kThisHost;
  }
  const bool mutual = use == Use::kGrpc && !scene.tls->client_ca.empty();
  return mutual ? Protection::kMutualTls : Protection::kTls;
}

}  // namespace

Protection check_listen_address(const std::string& address, Protection best) {
  if (!unix_path(address).empty()) {
    check_unix(address);
    return Protection::kThisHost;
  }
  const std::string host = host_of(address);
  if (best == Protection::kTls || best == Protection::kMutualTls) return best;
  if (is_loopback(host)) return Protection::kThisHost;
  if (best == Protection::kInsecureLab) return best;
  refuse(address, "host '" + host +
                      "' is not loopback: without TLS only 127.0.0.0/8, [::1], localhost and "
                      "unix:/path are served; give the scene server.tls, or hapticd "
                      "--insecure-lab for plain text on a network that is yours alone");
}

Listeners::Listeners(const ServerScene& scene, bool insecure_lab) {
  if (scene.listen.empty()) throw core::TransportError("no listen address");
  const auto add = [&](const std::string& address, Use use) {
    const Protection best = best_protection(scene, insecure_lab, use);
    addresses_.push_back({address, use, check_listen_address(address, best), 0});
  };
  for (const std::string& address : scene.listen) add(address, Use::kGrpc);
  if (scene.web) {
    for (const std::string& address : scene.web->listen) add(address, Use::kWeb);
  }
  if (!scene.metrics_listen.empty()) add(scene.metrics_listen, Use::kMetrics);
  if (!scene.udp_listen.empty()) {
    check_listen_address(scene.udp_listen, best_protection(scene, insecure_lab, Use::kGrpc));
  }
  for (FrontConfig::Address& address : addresses_) {
    const std::size_t before = sockets_.size();
    if (const std::string path = unix_path(address.name); !path.empty()) {
      bind_unix(address.name, path);
    } else {
      address.name = bind_name(address.name, SOCK_STREAM);
    }
    address.sockets = static_cast<std::uint32_t>(sockets_.size() - before);
  }
  if (!scene.udp_listen.empty()) udp_listen_ = bind_name(scene.udp_listen, SOCK_DGRAM);
}

std::vector<Descriptor> Listeners::sockets() const {
  std::vector<Descriptor> copies;
  for (const Descriptor& each : sockets_) {
    copies.emplace_back(fcntl(each.get(), F_DUPFD_CLOEXEC, 0));
    if (!copies.back()) throw core::TransportError(std::string("sockets: ") + strerror(errno));
  }
  return copies;
}

Listeners::File::File(std::string its_path) : path(std::move(its_path)) {
  struct stat made {};
  if (stat(path.c_str(), &made) != 0) return;
  device = made.st_dev;
  inode = made.st_ino;
}

Listeners::File::~File() {
  struct stat now {};
  const bool same = stat(path.c_str(), &now) == 0 && now.st_dev == device && now.st_ino == inode;
  if (same) unlink(path.c_str());
}

void Listeners::bind_unix(const std::string& address, const std::string& path) {
  const sockaddr_un name = unix_name(path);
  unlink(path.c_str());  // no process answers there: check_listen_address()
  Descriptor listener = bound(reinterpret_cast<const sockaddr*>(&name), sizeof name, SOCK_STREAM);
  if (!listener) refuse(address, std::string("cannot be bound: ") + std::strerror(errno));
  files_.push_back(std::make_unique<File>(path));
  sockets_.push_back(std::move(listener));
}

std::string Listeners::bind_name(const std::string& address, int type) {
  const std::string what = type == SOCK_DGRAM ? "UDP address '" : "listen address '";
  const auto cannot_bind = [&](const std::string& why) {
    return core::TransportError(what + address + "': cannot be bound: " + why);
  };
  const Addresses all = resolve(host_of(address), port_of(address), type);
  if (all.error != 0) throw cannot_bind(gai_strerror(all.error));
  int port = 0;
  int failed = 0;
  for (addrinfo* each = all.first.get(); each != nullptr; each = each->ai_next) {
    // The port lies at the same place in sockaddr_in and sockaddr_in6. If any port will do, the
    // sockets of one name share the one that the first of them got.
    auto& name = *reinterpret_cast<sockaddr_in*>(each->ai_addr);
    if (port != 0) name.sin_port = htons(static_cast<std::uint16_t>(port));
    Descriptor made = bound(each->ai_addr, each->ai_addrlen, type);
    if (!made) {
      failed = errno;
      // localhost has an address of IPv6 on hosts that have no IPv6.
      if (failed == EADDRNOTAVAIL || failed == EAFNOSUPPORT) continue;
      throw cannot_bind(std::strerror(failed));
    }
    sockaddr_storage got{};
    socklen_t size = sizeof got;
    getsockname(made.get(), reinterpret_cast<sockaddr*>(&got), &size);
    port = ntohs(reinterpret_cast<const sockaddr_in&>(got).sin_port);
    sockets_.push_back(std::move(made));
  }
  if (port == 0) throw cannot_bind(std::strerror(failed));
  return host_of(address) + ":" + std::to_string(port);
}

}  // namespace haptic::server
