#include "server/owner/link/listeners.hpp"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "haptic/core/error.hpp"
#include "server/crossing/packet_socket.hpp"

namespace haptic::server {
namespace {

using Use = FrontConfig::Use;

[[noreturn]] void refuse(const std::string& address, const std::string& why) {
  throw core::TransportError("listen address '" + address + "': " + why);
}

/// A process listens there, also if it takes no connections at the moment.
bool answers(const sockaddr_un& name) {
  const Descriptor caller(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  return connect(caller.get(), reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0 ||
         errno == EAGAIN;
}

sockaddr_un unix_name(const std::string& path) {
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  path.copy(name.sun_path, sizeof name.sun_path - 1);
  return name;
}

const std::string kChoose = "; choose another one: --listen, or --set a field of server";
void check_unix(const std::string& address) {
  const std::string path = unix_path(address);
  struct stat existing {};
  if (stat(path.c_str(), &existing) != 0) return;
  if (!S_ISSOCK(existing.st_mode)) refuse(address, "the path exists and is no socket");
  if (answers(unix_name(path))) refuse(address, "in use by another process" + kChoose);
}

/// Several sockets of this user may have the port from now on.
void share_port(const Descriptor& socket) {
  const int on = 1;
  setsockopt(socket.get(), SOL_SOCKET, SO_REUSEPORT, &on, sizeof on);
}

enum class Port : std::uint8_t { kFree, kOurs };

/// Empty, with errno set: it cannot be bound. kFree: no socket of any user may have the name yet.
Descriptor bound(const sockaddr* name, socklen_t size, int type, Port port = Port::kFree) {
  Descriptor made(socket(name->sa_family, type | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!made) return made;
  const bool listens = type == SOCK_STREAM;
  if (port == Port::kOurs) share_port(made);
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
  if (name->sa_family == AF_UNIX) refuse_descriptors(made.get());
  if (bind(made.get(), name, size) != 0) return {};
  share_port(made);
  if (listens && listen(made.get(), SOMAXCONN) != 0) return {};
  return made;
}

/// Everything that an honest front leaves as it was, and that another one may have changed.
std::vector<int> look_at(const Descriptor& socket) {
  std::vector<int> state;
  const auto option = [&](int level, int name) {
    int value = 0;
    socklen_t size = sizeof value;
    state.push_back(getsockopt(socket.get(), level, name, &value, &size) == 0 ? value : -errno);
  };
  for (const int name : {SO_ACCEPTCONN, SO_LOCK_FILTER, SO_KEEPALIVE, SO_REUSEADDR, SO_REUSEPORT,
                         SO_RCVLOWAT, SO_SNDBUF, SO_DONTROUTE, SO_MARK, SO_PRIORITY, SO_BROADCAST,
                         SO_BINDTOIFINDEX, kPassRights}) {
    option(SOL_SOCKET, name);
  }
  for (const int name : {TCP_DEFER_ACCEPT, TCP_MAXSEG, TCP_USER_TIMEOUT, TCP_NODELAY}) {
    option(IPPROTO_TCP, name);
  }
  socklen_t instructions = 0;  // of a filter
  getsockopt(socket.get(), SOL_SOCKET, SO_GET_FILTER, nullptr, &instructions);
  state.push_back(static_cast<int>(instructions));
  pollfd shut{socket.get(), POLLRDHUP, 0};  // a UNIX socket that was shut down says it listens
  poll(&shut, 1, 0);
  state.push_back(shut.revents);
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  state.push_back(getpeername(socket.get(), reinterpret_cast<sockaddr*>(&peer), &size));
  return state;
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
  for (const Bound& each : sockets_) {
    fcntl(each.socket.get(), F_SETFL, O_NONBLOCK);
    copies.emplace_back(fcntl(each.socket.get(), F_DUPFD_CLOEXEC, 0));
    if (!copies.back()) throw core::TransportError(std::string("sockets: ") + strerror(errno));
  }
  return copies;
}

void Listeners::keep(Descriptor socket, int type) {
  Bound& kept = sockets_.emplace_back();
  kept.type = type;
  kept.size = sizeof kept.name;
  getsockname(socket.get(), reinterpret_cast<sockaddr*>(&kept.name), &kept.size);
  kept.state = look_at(socket);
  kept.socket = std::move(socket);
}

void Listeners::check() {
  for (Bound& each : sockets_) {
    if (look_at(each.socket) == each.state) continue;
    spdlog::error("a front changed a socket that it was given: it is opened again");
    open_again(each);
  }
}

void Listeners::try_to_open_again() noexcept {
  for (Bound& each : sockets_) {
    try {
      open_again(each);
    } catch (const std::exception&) {
      each.state.clear();
    }
  }
}

void Listeners::open_again(Bound& old) {
  const auto* const name = reinterpret_cast<const sockaddr*>(&old.name);
  std::unique_ptr<File>* file = nullptr;
  if (name->sa_family == AF_UNIX) {
    const std::string path = reinterpret_cast<const sockaddr_un*>(name)->sun_path;
    for (auto& each : files_) {
      if (each->path == path) file = &each;
    }
    if (file != nullptr && (*file)->is_of_another()) {
      spdlog::error("'{}' is another's file by now: hapticd does not serve there any more", path);
      return;
    }
    unlink(path.c_str());
  } else {
    share_port(old.socket);  // it may have been taken away
  }
  Descriptor made = bound(name, old.size, old.type, Port::kOurs);
  if (!made) {
    throw core::TransportError(std::string("a socket cannot be opened again: ") +
                               std::strerror(errno));
  }
  if (file != nullptr) *file = std::make_unique<File>((*file)->path);
  shutdown(old.socket.get(), SHUT_RDWR);  // for all processes that have a copy
  old.state = look_at(made);
  old.socket = std::move(made);
}

Listeners::File::File(std::string its_path) : path(std::move(its_path)) {
  struct stat made {};
  if (stat(path.c_str(), &made) != 0) return;
  device = made.st_dev;
  inode = made.st_ino;
}

bool Listeners::File::is_of_another() const {
  struct stat now {};
  return stat(path.c_str(), &now) == 0 && (now.st_dev != device || now.st_ino != inode);
}

Listeners::File::~File() {
  if (!is_of_another()) unlink(path.c_str());
}

void Listeners::bind_unix(const std::string& address, const std::string& path) {
  const sockaddr_un name = unix_name(path);
  unlink(path.c_str());  // no process answers there: check_listen_address()
  Descriptor listener = bound(reinterpret_cast<const sockaddr*>(&name), sizeof name, SOCK_STREAM);
  if (!listener) refuse(address, std::string("cannot be bound: ") + std::strerror(errno));
  files_.push_back(std::make_unique<File>(path));
  keep(std::move(listener), SOCK_STREAM);
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
      throw cannot_bind(std::strerror(failed) + (failed == EADDRINUSE ? kChoose : ""));
    }
    keep(std::move(made), type);
    port = ntohs(reinterpret_cast<const sockaddr_in&>(sockets_.back().name).sin_port);
  }
  if (port == 0) throw cannot_bind(std::strerror(failed));
  return host_of(address) + ":" + std::to_string(port);
}

}  // namespace haptic::server
