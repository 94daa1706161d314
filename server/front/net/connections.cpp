#include "server/front/net/connections.hpp"

#include <fcntl.h>
#include <linux/sockios.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <map>
#include <utility>

#include "server/base/steady_now.hpp"
#include "server/base/thread_setup.hpp"
#include "server/front/net/connection.hpp"

namespace haptic::server {
namespace {

using namespace std::chrono_literals;

/// While a connection is open; and while the debts of all are above kHurryAbove.
constexpr auto kLookEvery = 10ms;
constexpr auto kHurry = 2ms;
constexpr double kHurryAbove = 16 * 1024;
constexpr auto kPause = 100ms;
/// A peer that acknowledges nothing for so long is gone, or does not read: a network that was
/// unplugged for 10 s finds its clients ready to connect again.
constexpr int kGoneMs = 8'000;
/// Messages are small; what waits in the kernel is not looked at yet.
constexpr int kReceiveBuffer = 64 * 1024;
/// A flood must not become a flood of the log.
constexpr auto kTellEvery = 1s;

Descriptor copy_of(const Descriptor& descriptor) {
  return Descriptor(fcntl(descriptor.get(), F_DUPFD_CLOEXEC, 0));
}

Descriptor open_spare() {
  return Descriptor(eventfd(0, EFD_CLOEXEC));
}

/// A client waits for the server's first words before it sends as much.
constexpr int kEarly = 16 * 1024;

/// More waits than an honest peer sends before it was accepted, or before it left.
bool flooded(const Descriptor& socket) {
  int waiting = 0;
  return ioctl(socket.get(), SIOCINQ, &waiting) == 0 && waiting > kEarly;
}

/// Drops the bytes that wait in the kernel: gRPC would still read them.
void drain(const Descriptor& socket) {
  while (recv(socket.get(), nullptr, 1 << 20, MSG_TRUNC | MSG_DONTWAIT) > 0) continue;
}

}  // namespace

Connections::Connections(std::vector<Listener> listeners, const ConnectionLimits& limits)
    : limits_(limits),
      listeners_(std::move(listeners)),
      spare_(open_spare()),
      wakes_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

Connections::~Connections() {
  stop();
}

void Connections::start(HandOver hand_over) {
  hand_over_ = std::move(hand_over);
  thread_ = std::thread([this] { run(); });
}

void Connections::close(core::Duration grace) {
  cut_at_.store((steady_now() + grace).time_since_epoch().count());
  static_cast<void>(eventfd_write(wakes_.get(), 1));
}

void Connections::look_now() {
  if (!asked_.exchange(true)) static_cast<void>(eventfd_write(wakes_.get(), 1));
}

void Connections::stop() {
  if (!thread_.joinable()) return;
  stopping_.store(true);
  static_cast<void>(eventfd_write(wakes_.get(), 1));
  thread_.join();
}

std::shared_ptr<Account> Connections::account(const std::string& peer) {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(open_.begin(), open_.end(), [&](const auto& each) {
    return !each->peer.grpc.empty() && each->peer.grpc == peer;
  });
  return found == open_.end() ? unread_ : (*found)->account;
}

std::size_t Connections::open() const {
  const std::lock_guard lock(mutex_);
  return open_.size();
}

void Connections::run() noexcept {
  set_thread_up("connections");
  std::vector<pollfd> wait;
  while (!stopping_.load()) {
    wait.assign(1, {wakes_.get(), POLLIN, 0});
    const bool closing = cut_at_.load() != 0;
    if (closing) listeners_.clear();
    const core::TimePoint before = steady_now();
    const bool accepts = before >= accepts_at_ && !(full_ && before < shut_until_);
    if (accepts) {
      for (const Listener& each : listeners_) wait.push_back({each.socket.get(), POLLIN, 0});
    }
    const bool look = closing || !accepts || !open_.empty();
    const auto every = hurry_ ? kHurry : kLookEvery;
    poll(wait.data(), wait.size(), look ? static_cast<int>(every.count()) : -1);
    eventfd_t woken = 0;
    static_cast<void>(eventfd_read(wakes_.get(), &woken));
    for (std::size_t i = 1; i < wait.size(); ++i) {
      if (wait[i].revents != 0) accept_all(listeners_[i - 1]);
    }
    forget_closed();
    const core::TimePoint now = steady_now();
    if (now - looked_ >= every || asked_.exchange(false)) look_after(now);
    if (closing && now.time_since_epoch().count() >= cut_at_.load()) {
      for (const auto& each : open_) cut(*each, "was open at the end of the server");
    }
  }
  for (const auto& each : open_) shutdown(each->socket.get(), SHUT_RDWR);
}

void Connections::accept_all(const Listener& listener) {
  for (unsigned i = 0; i < limits_.all; ++i) {
    Descriptor socket(
        accept4(listener.socket.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!socket && (errno == EMFILE || errno == ENFILE)) {
      // Accepted with the spare descriptor and closed at once: a full queue would keep all out.
      spare_ = Descriptor();
      const bool one = static_cast<bool>(
          Descriptor(accept4(listener.socket.get(), nullptr, nullptr, SOCK_CLOEXEC)));
      spare_ = open_spare();
      make_room(largest_peer());
      if (!one) return;
      cut_.fetch_add(1);
      continue;
    }
    if (!socket) return;
    admit(listener.address, std::move(socket));
  }
}

void Connections::admit(std::size_t address, Descriptor socket) {
  auto connection = std::make_unique<Connection>();
  connection->peer = peer_name(socket.get());
  if (connection->peer.owner.empty()) return;
  if (flooded(socket)) {
    cut_.fetch_add(1);
    return;
  }
  if (!connection->peer.grpc.empty()) {
    const int on = 1;
    setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    setsockopt(socket.get(), IPPROTO_TCP, TCP_USER_TIMEOUT, &kGoneMs, sizeof kGoneMs);
    setsockopt(socket.get(), SOL_SOCKET, SO_RCVBUF, &kReceiveBuffer, sizeof kReceiveBuffer);
  }
  const auto same = [&](const auto& other) {
    return !other->over && other->peer.owner == connection->peer.owner;
  };
  const auto left = [](const auto& other) { return !other->over; };
  if (std::count_if(open_.begin(), open_.end(), same) >= limits_.per_peer) {
    make_room(connection->peer.owner);
  } else if (std::count_if(open_.begin(), open_.end(), left) >= limits_.all) {
    make_room(largest_peer());
  }
  // Those that were cut are gRPC's until it has noticed: their descriptors are not free yet.
  forget_closed();
  connection->socket = copy_of(socket);
  if (!connection->socket) return;
  const std::shared_ptr<Account> account = connection->account;
  {
    const std::lock_guard lock(mutex_);
    open_.push_back(std::move(connection));
  }
  hand_over_(address, socket.release(), account);
}

std::string Connections::largest_peer() const {
  std::map<std::string, unsigned> count;
  std::pair<unsigned, std::string> largest;
  for (const auto& each : open_) {
    if (each->over) continue;
    const unsigned n = ++count[each->peer.owner];
    if (n > largest.first) largest = {n, each->peer.owner};
  }
  return largest.second;
}

void Connections::make_room(const std::string& peer) {
  Connection* first = nullptr;
  for (const auto& each : open_) {
    if (each->over || each->peer.owner != peer) continue;
    if (first == nullptr || each->account->worth() < first->account->worth()) first = each.get();
  }
  if (first != nullptr) cut(*first, "gave way to a newer one");
}

void Connections::forget_closed() {
  std::vector<pollfd> ended;
  ended.reserve(open_.size());
  for (const auto& each : open_) ended.push_back({each->socket.get(), 0, 0});
  poll(ended.data(), ended.size(), 0);
  for (std::size_t i = 0; i < open_.size(); ++i) {
    const bool hung_up = (ended[i].revents & (POLLHUP | POLLERR | POLLNVAL)) != 0;
    if (open_[i]->over || !(hung_up || open_[i]->account->left())) continue;
    open_[i]->over = true;
    if (!open_[i]->peer.grpc.empty() && flooded(open_[i]->socket)) drain(open_[i]->socket);
  }
  const std::lock_guard lock(mutex_);
  std::erase_if(open_, [](const auto& each) { return each->over; });
}

void Connections::look_after(core::TimePoint now) {
  const double since = looked_ == core::TimePoint{} ? 0.0 : core::seconds(now - looked_);
  const double forgiven = since * static_cast<double>(limits_.forgiven_per_second);
  looked_ = now;
  double sum = 0.0;
  Connection* largest = nullptr;
  for (const auto& each : open_) {
    if (each->peer.grpc.empty()) continue;
    const Traffic traffic = traffic_of(each->socket.get(), *each->account);
    each->debt.book(traffic, forgiven);
    each->suspicion.book(traffic, since);
    // A session's samples may come in while nothing gets out: that is its network's fault.
    if (each->unread.book(traffic, now) && each->account->worth() < 2) {
      offends(*each, "asks and does not read");
      continue;
    }
    if (each->account->calls() > limits_.calls) {
      offends(*each, "began too many calls");
      continue;
    }
    if (each->debt.bytes() > static_cast<double>(limits_.debt)) {
      offends(*each, "sent bytes that mean nothing");
      continue;
    }
    sum += each->debt.bytes();
    if (largest == nullptr || each->debt.bytes() > largest->debt.bytes()) largest = each.get();
  }
  if (sum > static_cast<double>(limits_.debt_of_all)) {
    offends(*largest, "sent most of the bytes that mean nothing");
  }
  hurry_ = sum > kHurryAbove || full_;
  look_at_memory(now);
}

void Connections::offends(Connection& connection, const char* why) {
  cut(connection, why);
  // A peer that comes again at once finds the door shut until what it began is tidied up.
  accepts_at_ = steady_now() + kPause;
}

void Connections::cut(Connection& connection, const char* why) {
  if (connection.over) return;
  shutdown(connection.socket.get(), SHUT_RDWR);
  drain(connection.socket);
  connection.over = true;
  trim_ = true;
  cut_.fetch_add(1);
  const core::TimePoint now = steady_now();
  if (now - told_ < kTellEvery) return;
  told_ = now;
  spdlog::warn("a connection of {} was cut: it {} ({} were cut since the start)",
               connection.peer.owner, why, cut_.load());
}

}  // namespace haptic::server
