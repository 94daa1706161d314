#include "server/owner/local/control_socket.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <exception>
#include <thread>

#include "server/base/thread_setup.hpp"

namespace haptic::server {
namespace {

std::atomic<int> closing_elsewhere{0};

/// Size of the next message, which stays there: as recv(), or -2 if it brings descriptors.
ssize_t size_of_next(const Descriptor& socket) {
  msghdr message{};
  const ssize_t size = recvmsg(socket.get(), &message, MSG_PEEK | MSG_TRUNC | MSG_DONTWAIT);
  return size >= 0 && (message.msg_flags & MSG_CTRUNC) != 0 ? -2 : size;
}

/// The descriptors that a message brings are closed with the socket, which waits for as long as
/// their sender likes (SO_LINGER): then a thread of its own does it.
void close_elsewhere(Descriptor socket) {
  shutdown(socket.get(), SHUT_RD);  // from now on it gets nothing more
  ssize_t next = 0;
  while ((next = size_of_next(socket)) > 0) recv(socket.get(), nullptr, 0, MSG_DONTWAIT);
  if (next != -2) return;
  ++closing_elsewhere;
  try {
    std::thread([number = socket.release()] {
      set_thread_up("close aside");
      close(number);
      --closing_elsewhere;
    }).detach();
  } catch (const std::exception&) {  // no thread is to be had: the socket stays open
  }
}

}  // namespace

ControlSocket::ControlSocket(const ControlPlaces& places, Handler handler, Barred barred)
    : handler_(std::move(handler)), barred_(std::move(barred)), listeners_(places) {}

/// Not while sockets that they burdened are still being closed.
bool ControlSocket::serves_others(core::TimePoint now) const {
  return now >= others_at_ && closing_elsewhere.load() < kMostClosing;
}

core::Duration ControlSocket::add_to(std::vector<pollfd>& wait, core::TimePoint now) const {
  const bool others = serves_others(now);
  for (const ControlListeners::Listener& listener : listeners_.all()) {
    if (others || !listener.for_all) wait.push_back({listener.socket.get(), POLLIN, 0});
  }
  for (const Connection& connection : connections_) {
    if (others || connection.trusted) wait.push_back({connection.socket.get(), POLLIN, 0});
  }
  return now >= others_at_ ? core::Duration(std::chrono::seconds(1)) : others_at_ - now;
}

void ControlSocket::turn(core::TimePoint now) {
  const bool others = serves_others(now);
  bool came = false;
  accepted_.clear();
  for (const ControlListeners::Listener& listener : listeners_.all()) {
    if (!listener.for_all) accept_from(listener);
  }
  for (const ControlListeners::Listener& listener : listeners_.all()) {
    if (listener.for_all && others) came = accept_from(listener) || came;
  }
  for (std::size_t i = connections_.size(); i-- > 0;) {
    if (connections_[i].trusted || others) read(connections_[i]);
  }
  std::erase_if(connections_, [](const Connection& c) { return !c.socket; });
  const auto rank = [](const ControlCommand& c) {
    return (c.kind == ControlCommand::Kind::kStop ? 0 : 2) + (c.trusted ? 0 : 1);
  };
  std::stable_sort(commands_.begin(), commands_.end(),
                   [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  for (const ControlCommand& command : commands_) {
    came = came || !command.trusted;
    handler_(command);
  }
  commands_.clear();
  if (!came) return;
  if (now - round_ >= kRound) {
    round_ = now;
    turns_ = 0;
  }
  if (++turns_ >= kTurnsPerRound) others_at_ = round_ + kRound;
}

bool ControlSocket::accept_from(const ControlListeners::Listener& listener) {
  for (std::size_t i = 0; i < kAcceptedPerTurn; ++i) {
    Descriptor socket(
        accept4(listener.socket.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!socket) return i > 0;
    accept_one(std::move(socket));
  }
  return true;
}

void ControlSocket::accept_one(Descriptor socket) {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (getsockopt(socket.get(), SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return;
  if (barred_ && barred_(peer.pid)) return close_elsewhere(std::move(socket));
  // It cannot be told any more whose process one was that has ended.
  const bool ended = peer.pid > 0 && getsid(peer.pid) < 0;
  const bool trusted = !ended && (peer.uid == 0 || peer.uid == geteuid());
  if (!trusted && has_too_many(peer.uid)) return close_elsewhere(std::move(socket));
  make_room(trusted, peer.uid);
  connections_.push_back({std::move(socket), ++last_number_, peer.uid, trusted, false});
  read(connections_.back());
}

bool ControlSocket::has_too_many(unsigned user) {
  auto mine = std::find_if(accepted_.begin(), accepted_.end(),
                           [&](const auto& entry) { return entry.first == user; });
  if (mine == accepted_.end()) mine = accepted_.insert(mine, {user, 0});
  return ++mine->second > kPerUser;
}

/// The oldest one gives way to a newcomer, first one that has not asked yet: so idle ones keep no
/// other out. One user's give way to that user's, and trusted ones to trusted ones alone.
void ControlSocket::make_room(bool trusted, unsigned user) {
  const auto give_way = [&](std::size_t places, const auto& belongs) {
    const auto taken = std::count_if(connections_.begin(), connections_.end(), belongs);
    if (static_cast<std::size_t>(taken) < places) return;
    auto oldest = std::find_if(connections_.begin(), connections_.end(),
                               [&](const Connection& c) { return belongs(c) && !c.asked; });
    if (oldest == connections_.end()) {
      oldest = std::find_if(connections_.begin(), connections_.end(), belongs);
    }
    close_elsewhere(std::move(oldest->socket));
    connections_.erase(oldest);
  };
  if (!trusted) {
    give_way(kPerUser, [&](const Connection& c) { return !c.trusted && c.user == user; });
  }
  give_way(kConnections, [&](const Connection& c) { return c.trusted == trusted; });
}

void ControlSocket::read(Connection& connection) {
  const ssize_t next = size_of_next(connection.socket);
  if (next == -1 && errno == EAGAIN) return;
  if (next <= 0) return close_elsewhere(std::move(connection.socket));  // gone, or not to be taken
  std::array<char, ControlCommand::kLongest + 1> bytes{};
  const ssize_t got = recv(connection.socket.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (connection.asked || got < 0) return;
  connection.asked = true;
  ParsedCommand parsed = parse_command({bytes.data(), static_cast<std::size_t>(got)});
  ControlCommand& command = parsed.command;
  using Kind = ControlCommand::Kind;
  const bool for_all = command.kind == Kind::kStop || command.kind == Kind::kHealth;
  if (parsed.wrong.empty() && !for_all && !connection.trusted) {
    parsed.wrong = "refused: only for the user that runs hapticd, and root";
  }
  if (!parsed.wrong.empty()) return answer(connection.number, parsed.wrong);
  command.reply_to = connection.number;
  command.user = connection.user;
  command.trusted = connection.trusted;
  commands_.push_back(std::move(command));
}

void ControlSocket::answer(std::uint64_t reply_to, std::string_view text) {
  for (Connection& connection : connections_) {
    if (connection.number != reply_to) continue;
    ::send(connection.socket.get(), text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    close_elsewhere(std::move(connection.socket));
  }
}

}  // namespace haptic::server
