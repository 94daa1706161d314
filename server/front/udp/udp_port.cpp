#include "server/front/udp/udp_port.hpp"

#include <asio/steady_timer.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "server/base/steady_now.hpp"
#include "server/base/thread_setup.hpp"
#include "server/crossing/listen_address.hpp"
#include "server/front/net/wire_time.hpp"
#include "server/front/udp/udp_socket.hpp"

namespace haptic::server {
namespace {

/// Between two looks at the paths' timers: a flood must not keep a challenge waiting for longer.
constexpr int kLongestDrain = 256;
/// Keys wear out over days: it is enough to look now and then.
constexpr core::Duration kLongestPause = std::chrono::seconds(1);

/// Host that a client is told; empty: the host that it opened its stream to. To a UNIX socket that
/// means 127.0.0.1.
std::string host_told(const asio::ip::address& bound, const std::vector<std::string>& streams) {
  if (bound.is_unspecified()) return {};
  std::string host = bound.to_string();
  bool same = false;
  for (const std::string& stream : streams) {
    if (stream.rfind("unix:", 0) == 0) {
      if (host != "127.0.0.1") return host;
      continue;
    }
    std::string name = host_of(stream);
    if (name == "localhost") name = "127.0.0.1";
    same = same || name == host || name == '[' + host + ']';
  }
  return same ? std::string{} : host;
}

core::TimePoint next_step(ServerPath& path) {
  return path.with(
      [](const wire::PathEnd& end) { return core::TimePoint(end.next_step().time_since_epoch()); });
}

bool wants_rekey(ServerPath& path, core::TimePoint now) {
  return path.with([now](const wire::PathEnd& end) { return end.wants_rekey(to_wire(now)); });
}

}  // namespace

struct UdpPort::Impl {
  Impl(Descriptor bound, const std::vector<std::string>& streams, ArrivalClock arrival_clock)
      : clock(std::move(arrival_clock)),
        socket(context, std::move(bound)),
        timer(context),
        host(host_told(socket.bound().address(), streams)) {}
  void rekey(const std::shared_ptr<ServerPath>& path) {
    wire::PathKeys keys;
    {
      const std::lock_guard lock(mutex);
      const core::TimePoint now = clock({});
      bool open = false;  // it may have been closed meanwhile
      std::erase_if(paths, [&](const auto& entry) {
        open = open || entry.second == path;
        return entry.second == path && !path->with([&](wire::PathEnd& end) {
          return end.knows(entry.first, to_wire(now));
        });
      });
      if (!open) return;
      keys = unused_keys();
      paths[keys.path_id] = path;
    }
    path->rekey(keys);
  }

  using Paths = std::unordered_map<std::uint32_t, std::shared_ptr<ServerPath>>;

  [[nodiscard]] wire::PathKeys unused_keys() const {
    wire::PathKeys keys = wire::fresh_keys();
    while (paths.contains(keys.path_id)) keys = wire::fresh_keys();
    return keys;
  }

  void wait_for_datagrams() {
    socket.waitable().async_wait(asio::socket_base::wait_read, [this](asio::error_code error) {
      if (error) return;
      drain();
      step();
      wait_for_datagrams();
    });
  }

  void drain() {
    for (int i = 0; i < kLongestDrain; ++i) {
      const Arrived arrived = socket.receive(buffer);
      if (!arrived.any) return;
      take(arrived);
    }
  }

  void take(const Arrived& arrived) {
    if (arrived.size > wire::kLargestDatagram) return reject(wire::Rejection::kLength);
    const auto datagram = wire::ConstBytes(buffer).first(arrived.size);
    const wire::HeaderReading reading = wire::read_header(datagram);
    if (reading.rejection != wire::Rejection::kNone) return reject(reading.rejection);
    std::shared_ptr<ServerPath> path;
    {
      const std::lock_guard lock(mutex);
      const auto entry = paths.find(reading.header.path_id);
      if (entry != paths.end()) path = entry->second;
    }
    if (!path) return reject(wire::Rejection::kUnknownPath);
    const wire::Rejection why = path->receive(datagram, arrived.from, clock(arrived.waited));
    if (why != wire::Rejection::kNone) count(by_paths, why);
  }

  using Counters = std::array<std::atomic<std::uint64_t>, wire::kRejections>;
  static void count(Counters& counters, wire::Rejection why) {
    counters[static_cast<std::size_t>(why)].fetch_add(1, std::memory_order_relaxed);
  }
  void reject(wire::Rejection why) { count(rejected, why); }

  void step() {
    const core::TimePoint now = clock({});
    std::vector<std::shared_ptr<ServerPath>> due;
    {
      const std::lock_guard lock(mutex);
      for (const auto& [id, path] : paths) {
        if (next_step(*path) <= now || wants_rekey(*path, now)) due.push_back(path);
      }
    }
    for (const auto& path : due) {
      path->step(now);
      if (wants_rekey(*path, now)) rekey(path);
    }
    schedule();
  }

  /// Paths change when something comes, and that leads to step(); so the timer is never late.
  void schedule() {
    const core::TimePoint now = clock({});
    core::TimePoint next = now + kLongestPause;
    {
      const std::lock_guard lock(mutex);
      for (const auto& [id, path] : paths) next = std::min(next, next_step(*path));
    }
    timer.expires_after(std::max(next - now, core::Duration(0)));
    timer.async_wait([this](asio::error_code error) {
      if (error) return;
      drain();  // before any judgement about silence
      step();
    });
  }

  const ArrivalClock clock;
  asio::io_context context{1};
  UdpSocket socket;
  asio::steady_timer timer;
  const std::string host;
  std::array<std::uint8_t, wire::kLargestDatagram + 1> buffer{};
  mutable std::mutex mutex;
  Paths paths{};
  Counters rejected{};
  Counters by_paths{};
  std::thread thread{};
};

UdpPort::UdpPort(Descriptor bound, const std::vector<std::string>& streams, ArrivalClock clock)
    : impl_(std::make_unique<Impl>(std::move(bound), streams, std::move(clock))) {}

UdpPort::~UdpPort() {
  stop();
}

void UdpPort::start() {
  impl_->wait_for_datagrams();
  impl_->schedule();
  impl_->thread = std::thread([this] {
    set_thread_up("haptic-udp");
    impl_->context.run();
  });
}

void UdpPort::stop() {
  impl_->context.stop();
  if (impl_->thread.joinable()) impl_->thread.join();
}

UdpPort::Opened UdpPort::open(std::weak_ptr<UdpSink> sink, core::Duration nominal_period) {
  Opened opened;
  wire::PathEndSetup setup;
  setup.end = wire::End::kServer;
  setup.rules.nominal_period = nominal_period;
  setup.send = [this](const wire::PeerAddress& to, wire::ConstBytes datagram) {
    impl_->socket.send(to, datagram);
  };
  const std::lock_guard lock(impl_->mutex);
  opened.keys = setup.keys = impl_->unused_keys();
  opened.path = std::make_shared<ServerPath>(std::move(setup), std::move(sink));
  impl_->paths[opened.keys.path_id] = opened.path;
  return opened;
}

void UdpPort::close(const std::shared_ptr<ServerPath>& path) {
  path->with([](wire::PathEnd& end) { end.close(); });
  const std::lock_guard lock(impl_->mutex);
  std::erase_if(impl_->paths, [&](const auto& entry) { return entry.second == path; });
}

void UdpPort::rekey(const std::shared_ptr<ServerPath>& path) {
  impl_->rekey(path);
}

std::size_t UdpPort::path_ids() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->paths.size();
}

const std::string& UdpPort::host() const {
  return impl_->host;
}

std::uint16_t UdpPort::port() const {
  return impl_->socket.bound().port();
}

std::uint64_t UdpPort::rejected(wire::Rejection why) const {
  return impl_->rejected[static_cast<std::size_t>(why)].load(std::memory_order_relaxed);
}

std::uint64_t UdpPort::dropped(wire::Rejection why) const {
  return rejected(why) +
         impl_->by_paths[static_cast<std::size_t>(why)].load(std::memory_order_relaxed);
}

}  // namespace haptic::server
