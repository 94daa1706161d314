#include "server/owner/local/control_socket.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstring>

#include "haptic/core/error.hpp"

namespace haptic::server {
namespace {

using CommandKind = ControlSocket::Command::Kind;

}  // namespace

ParsedCommand parse_command(std::string_view text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == '\0')) text.remove_suffix(1);
  if (text.size() > ControlSocket::kLongestCommand) return {{}, "refused: too long"};
  const std::size_t line = text.find('\n');
  const std::string_view rest = line == std::string_view::npos ? "" : text.substr(line + 1);
  text = text.substr(0, line);
  const std::size_t blank = text.find(' ');
  const std::string_view word = text.substr(0, blank);
  ControlSocket::Command command;
  if (blank != std::string_view::npos) command.device = text.substr(blank + 1);
  struct Word {
    std::string_view text;
    CommandKind kind;
    bool of_device;
  };
  static constexpr std::array kWords{Word{"stop", CommandKind::kStop, true},
                                     Word{"clear", CommandKind::kClear, true},
                                     Word{"health", CommandKind::kHealth, false},
                                     Word{"restart-front", CommandKind::kRestartFront, false}};
  for (const Word& known : kWords) {
    if (word != known.text) continue;
    if (!(command.device.empty() && rest.empty()) && !known.of_device) break;
    command.kind = known.kind;
    command.reason = rest;
    if (known.kind == CommandKind::kClear && !rest.empty()) {
      const auto end = rest.data() + rest.size();
      if (std::from_chars(rest.data(), end, command.faults).ptr != end) {
        return {{}, "refused: the faults must be a number, their bits"};
      }
    }
    return {command, {}};
  }
  return {{}, "refused: must be stop [DEVICE], clear [DEVICE], health or restart-front"};
}

std::string control_name(const std::string& address) {
  constexpr std::string_view kUnix = "unix:";
  if (address.rfind(kUnix, 0) == 0) return "hapticd" + address.substr(kUnix.size());
  return "hapticd/" + address;
}

ControlSocket::ControlSocket(const std::string& name, Handler handler)
    : handler_(std::move(handler)),
      listener_(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  // A name of the abstract namespace begins with a zero byte; what is too long is cut, by
  // hapticctl alike.
  const std::size_t size = std::min(name.size(), sizeof address.sun_path - 1);
  std::copy_n(name.data(), size, address.sun_path + 1);
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + size);
  if (bind(listener_.get(), reinterpret_cast<const sockaddr*>(&address), length) != 0 ||
      listen(listener_.get(), SOMAXCONN) != 0) {
    throw core::TransportError("control socket '@" + name + "': " + std::strerror(errno));
  }
}

void ControlSocket::add_to(std::vector<pollfd>& wait) const {
  wait.push_back({listener_.get(), POLLIN, 0});
  for (const Connection& connection : connections_) {
    wait.push_back({connection.socket.get(), POLLIN, 0});
  }
}

void ControlSocket::turn() {
  for (std::size_t i = 0; i < kConnections; ++i) {
    Descriptor socket(accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!socket) break;
    accept_one(std::move(socket));
  }
  for (std::size_t i = connections_.size(); i-- > 0;) read(connections_[i]);
  std::erase_if(connections_, [](const Connection& c) { return !c.socket; });
}

void ControlSocket::accept_one(Descriptor socket) {
  ucred peer{};
  socklen_t size = sizeof peer;
  getsockopt(socket.get(), SOL_SOCKET, SO_PEERCRED, &peer, &size);
  // One that has not asked yet gives way to a newcomer: so idle ones keep no other out.
  if (connections_.size() == kConnections) {
    auto idle = std::find_if(connections_.begin(), connections_.end(),
                             [](const Connection& c) { return !c.asked; });
    if (idle == connections_.end()) idle = connections_.begin();
    connections_.erase(idle);
  }
  connections_.push_back({std::move(socket), ++last_number_, peer.uid, false});
  read(connections_.back());
}

void ControlSocket::read(Connection& connection) {
  std::array<char, kLongestCommand + 1> bytes{};
  const ssize_t got = recv(connection.socket.get(), bytes.data(), bytes.size(), 0);
  if (got < 0 && errno == EAGAIN) return;
  if (got <= 0) {
    connection.socket = Descriptor();
    return;
  }
  if (connection.asked) return;
  connection.asked = true;
  ParsedCommand parsed = parse_command({bytes.data(), static_cast<std::size_t>(got)});
  const CommandKind kind = parsed.command.kind;
  const bool for_all = kind == CommandKind::kStop || kind == CommandKind::kHealth;
  if (parsed.wrong.empty() && !for_all && connection.user != 0 && connection.user != geteuid()) {
    parsed.wrong = "refused: only for the user that runs hapticd, and root";
  }
  if (!parsed.wrong.empty()) return answer(connection.number, parsed.wrong);
  parsed.command.reply_to = connection.number;
  parsed.command.user = connection.user;
  handler_(parsed.command);
}

void ControlSocket::answer(std::uint64_t reply_to, std::string_view text) {
  for (Connection& connection : connections_) {
    if (connection.number != reply_to) continue;
    ::send(connection.socket.get(), text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    connection.socket = Descriptor();
  }
}

}  // namespace haptic::server
