#include "server/udp/udp_port.hpp"

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
#include "server/udp/udp_socket.hpp"

namespace haptic::server {
namespace {

/// Between two looks at the paths' timers: a flood must not keep a challenge waiting for longer.
constexpr int kLongestDrain = 256;
/// Keys wear out over days: it is enough to look now and then.
constexpr core::Duration kLongestPause = std::chrono::seconds(1);

/// What a client is told; empty: the host that it opened its stream to. To a UNIX socket that means
/// 127.0.0.1.
std::string host_told(const asio::ip::address& bound, const std::vector<std::string>& streams) {
  if (bound.is_unspecified()) return {};
  std::string host = bound.to_string();
  bool same = false;
  for (const std::string& stream : streams) {
    if (stream.rfind("unix:", 0) == 0) {
      if (host != "127.0.0.1") return host;
      continue;
    }
    std::string name = stream.substr(0, stream.rfind(':'));
    if (name == "localhost") name = "127.0.0.1";
    same = same || name == host || name == '[' + host + ']';
  }
  return same ? std::string{} : host;
}

}  // namespace

class UdpPort::Impl {
 public:
  Impl(const std::string& listen, const std::vector<std::string>& streams, ArrivalClock clock)
      : clock_(std::move(clock)),
        socket_(context_, listen),
        timer_(context_),
        host_(host_told(socket_.bound().address(), streams)) {}
  ~Impl() { stop(); }

  void start() {
    wait_for_datagrams();
    schedule();
    thread_ = std::thread([this] {
      set_thread_up("haptic-udp");
      context_.run();
    });
  }

  void stop() {
    context_.stop();
    if (thread_.joinable()) thread_.join();
  }

  Opened open(std::weak_ptr<UdpSink> sink, core::Duration nominal_period) {
    Opened opened;
    wire::PathEndSetup setup;
    setup.end = wire::End::kServer;
    setup.rules.nominal_period = nominal_period;
    setup.send = [this](const wire::PeerAddress& to, wire::ConstBytes datagram) {
      socket_.send(to, datagram);
    };
    const std::lock_guard lock(mutex_);
    opened.keys = setup.keys = unused_keys();
    opened.path = std::make_shared<ServerPath>(std::move(setup), std::move(sink));
    paths_[opened.keys.path_id] = opened.path;
    return opened;
  }

  void close(const std::shared_ptr<ServerPath>& path) {
    path->close();
    const std::lock_guard lock(mutex_);
    std::erase_if(paths_, [&](const auto& entry) { return entry.second == path; });
  }

  void rekey(const std::shared_ptr<ServerPath>& path) {
    wire::PathKeys keys;
    {
      const std::lock_guard lock(mutex_);
      const core::TimePoint now = clock_({});
      bool open = false;  // it may have been closed meanwhile
      std::erase_if(paths_, [&](const auto& entry) {
        open = open || entry.second == path;
        return entry.second == path && !path->knows(entry.first, now);
      });
      if (!open) return;
      keys = unused_keys();
      paths_[keys.path_id] = path;
    }
    path->rekey(keys);
  }

  [[nodiscard]] std::size_t path_ids() const {
    const std::lock_guard lock(mutex_);
    return paths_.size();
  }
  [[nodiscard]] const std::string& host() const { return host_; }
  [[nodiscard]] asio::ip::udp::endpoint bound() const { return socket_.bound(); }
  [[nodiscard]] std::uint64_t rejected(wire::Rejection why) const {
    return rejected_[static_cast<std::size_t>(why)].load(std::memory_order_relaxed);
  }
  [[nodiscard]] std::uint64_t dropped(wire::Rejection why) const {
    return rejected(why) + by_paths_[static_cast<std::size_t>(why)].load(std::memory_order_relaxed);
  }

 private:
  using Paths = std::unordered_map<std::uint32_t, std::shared_ptr<ServerPath>>;

  [[nodiscard]] wire::PathKeys unused_keys() const {
    wire::PathKeys keys = wire::fresh_keys();
    while (paths_.contains(keys.path_id)) keys = wire::fresh_keys();
    return keys;
  }

  void wait_for_datagrams() {
    socket_.waitable().async_wait(asio::socket_base::wait_read, [this](asio::error_code error) {
      if (error) return;
      drain();
      step();
      wait_for_datagrams();
    });
  }

  void drain() {
    for (int i = 0; i < kLongestDrain; ++i) {
      const Arrived arrived = socket_.receive(buffer_);
      if (!arrived.any) return;
      take(arrived);
    }
  }

  void take(const Arrived& arrived) {
    if (arrived.size > wire::kLargestDatagram) return reject(wire::Rejection::kLength);
    const auto datagram = wire::ConstBytes(buffer_).first(arrived.size);
    const wire::HeaderReading reading = wire::read_header(datagram);
    if (reading.rejection != wire::Rejection::kNone) return reject(reading.rejection);
    std::shared_ptr<ServerPath> path;
    {
      const std::lock_guard lock(mutex_);
      const auto entry = paths_.find(reading.header.path_id);
      if (entry != paths_.end()) path = entry->second;
    }
    if (!path) return reject(wire::Rejection::kUnknownPath);
    const wire::Rejection why = path->receive(datagram, arrived.from, clock_(arrived.waited));
    if (why != wire::Rejection::kNone) count(by_paths_, why);
  }

  using Counters = std::array<std::atomic<std::uint64_t>, wire::kRejections>;
  static void count(Counters& counters, wire::Rejection why) {
    counters[static_cast<std::size_t>(why)].fetch_add(1, std::memory_order_relaxed);
  }
  void reject(wire::Rejection why) { count(rejected_, why); }

  void step() {
    const core::TimePoint now = clock_({});
    std::vector<std::shared_ptr<ServerPath>> due;
    {
      const std::lock_guard lock(mutex_);
      for (const auto& [id, path] : paths_) {
        if (path->next_step() <= now || path->wants_rekey(now)) due.push_back(path);
      }
    }
    for (const auto& path : due) {
      path->step(now);
      if (path->wants_rekey(now)) rekey(path);
    }
    schedule();
  }

  /// Paths change when something comes, and that leads to step(); so the timer is never late.
  void schedule() {
    const core::TimePoint now = clock_({});
    core::TimePoint next = now + kLongestPause;
    {
      const std::lock_guard lock(mutex_);
      for (const auto& [id, path] : paths_) next = std::min(next, path->next_step());
    }
    timer_.expires_after(std::max(next - now, core::Duration(0)));
    timer_.async_wait([this](asio::error_code error) {
      if (error) return;
      drain();  // before any judgement about silence
      step();
    });
  }

  const ArrivalClock clock_;
  asio::io_context context_{1};
  UdpSocket socket_;
  asio::steady_timer timer_;
  const std::string host_;
  std::array<std::uint8_t, wire::kLargestDatagram + 1> buffer_{};
  mutable std::mutex mutex_;
  Paths paths_{};
  Counters rejected_{};
  Counters by_paths_{};
  std::thread thread_{};
};

UdpPort::UdpPort(const std::string& listen, const std::vector<std::string>& streams,
                 ArrivalClock clock)
    : impl_(std::make_unique<Impl>(listen, streams, std::move(clock))) {}
UdpPort::~UdpPort() = default;

void UdpPort::start() {
  impl_->start();
}
void UdpPort::stop() {
  impl_->stop();
}
UdpPort::Opened UdpPort::open(std::weak_ptr<UdpSink> sink, core::Duration nominal_period) {
  return impl_->open(std::move(sink), nominal_period);
}
void UdpPort::close(const std::shared_ptr<ServerPath>& path) {
  impl_->close(path);
}
void UdpPort::rekey(const std::shared_ptr<ServerPath>& path) {
  impl_->rekey(path);
}
std::size_t UdpPort::path_ids() const {
  return impl_->path_ids();
}
std::string UdpPort::host() const {
  return impl_->host();
}
std::uint16_t UdpPort::port() const {
  return impl_->bound().port();
}
std::uint64_t UdpPort::rejected(wire::Rejection why) const {
  return impl_->rejected(why);
}
std::uint64_t UdpPort::dropped(wire::Rejection why) const {
  return impl_->dropped(why);
}

}  // namespace haptic::server
