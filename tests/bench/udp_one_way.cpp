#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <stdexcept>
#include <thread>

#include "server/front/messages.hpp"
#include "server/ingress/ingress.hpp"
#include "server/udp/udp_port.hpp"
#include "tests/bench/network.hpp"
#include "tests/bench/network_sample.hpp"
#include "tests/bench/paired.hpp"
#include "tests/support/udp_end.hpp"

namespace haptic::bench {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr int kSamples = 250;  // per block
constexpr milliseconds kEvery{4};

/// The server's own way from socket to mailbox, for one session; takes the time when the sample
/// lies in the mailbox.
class ToMailbox final : public server::UdpSink {
 public:
  ToMailbox() : ingress_(mailbox_, 2) { ingress_.begin_lease(1, 250.0, milliseconds(100)); }

  void on_udp_sample(const v1::ProxySample& sample, core::TimePoint arrival) override {
    server::ProxySample flat;
    server::from_proto(sample, flat);
    flat.epoch = 1;
    flat.carrier = server::Carrier::kUdp;
    flat.arrival = arrival;
    const server::Verdict verdict = ingress_.accept(flat);
    if (verdict.verdict != server::IngressVerdict::kAccepted) return;  // a clump: not timed here
    const std::lock_guard lock(mutex);
    one_way_us.push_back(static_cast<double>(now_ns() - sample.source_time_ns()) * 1e-3);
  }
  void on_udp_change(wire::PathChange /*change*/) override {}
  void on_udp_keys(const wire::PathKeys& /*keys*/) override {}

  std::mutex mutex;
  std::vector<double> one_way_us{};

 private:
  core::Mailbox<core::ProxySnapshot> mailbox_{};
  server::Ingress ingress_;
};

template <typename Send>
void paced(const Send& send) {
  auto next = Clock::now();
  for (int i = 0; i < kSamples; ++i) {
    next += kEvery;
    std::this_thread::sleep_until(next);
    send();
  }
  std::this_thread::sleep_for(milliseconds(20));
}

/// Both ends of the path, open from the first block to the last.
class Path {
 public:
  Path() : port_("127.0.0.1:0"), sink_(std::make_shared<ToMailbox>()) {
    opened_ = port_.open(std::weak_ptr<server::UdpSink>(sink_), kEvery);
    port_.start();
    client_ = std::make_unique<test::UdpEnd>(wire::End::kClient, opened_.keys, port_.port());
    const auto give_up = Clock::now() + std::chrono::seconds(20);
    while (!client_->in_use()) {
      if (Clock::now() > give_up) throw std::runtime_error("the UDP path never opened");
      std::this_thread::sleep_for(milliseconds(1));
    }
    send();
    size_ = sample_.SerializeAsString().size() + wire::kHeaderSize + wire::kTagSize;
  }
  ~Path() {
    client_.reset();
    port_.stop();
  }

  double block() {
    {
      const std::lock_guard lock(sink_->mutex);
      sink_->one_way_us.clear();
    }
    paced([this] { send(); });
    const std::lock_guard lock(sink_->mutex);
    return percentile(sink_->one_way_us, 0.5);
  }
  [[nodiscard]] std::size_t datagram_size() const { return size_; }

 private:
  void send() {
    fill(sample_, ++seq_);
    client_->send(sample_.SerializeAsString());
  }
  server::UdpPort port_;
  std::shared_ptr<ToMailbox> sink_;
  server::UdpPort::Opened opened_{};
  std::unique_ptr<test::UdpEnd> client_;
  v1::ProxySample sample_;
  std::uint64_t seq_{0};
  std::size_t size_{0};
};

/// The peer: a datagram of the same size that holds the time it left at, and a thread that waits
/// for it.
class RawUdp {
 public:
  explicit RawUdp(std::size_t size) : datagram_(size, 0) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    if (in_ < 0 || out_ < 0 || ::bind(in_, reinterpret_cast<sockaddr*>(&address), length) != 0 ||
        ::getsockname(in_, reinterpret_cast<sockaddr*>(&address), &length) != 0 ||
        ::connect(out_, reinterpret_cast<sockaddr*>(&address), length) != 0) {
      throw std::runtime_error("no loopback socket");
    }
    thread_ = std::thread([this] { receive(); });
  }
  ~RawUdp() {
    running_ = false;
    thread_.join();
    ::close(in_);
    ::close(out_);
  }
  RawUdp(const RawUdp&) = delete;
  RawUdp& operator=(const RawUdp&) = delete;

  double block() {
    {
      const std::lock_guard lock(mutex_);
      one_way_us_.clear();
    }
    paced([this] {
      const std::int64_t now = now_ns();
      std::memcpy(datagram_.data(), &now, sizeof now);
      static_cast<void>(::send(out_, datagram_.data(), datagram_.size(), 0));
    });
    const std::lock_guard lock(mutex_);
    return percentile(one_way_us_, 0.5);
  }

 private:
  void receive() {
    std::vector<char> buffer(2000);
    while (running_) {
      pollfd waiting{in_, POLLIN, 0};
      if (::poll(&waiting, 1, 50) <= 0) continue;
      if (::recv(in_, buffer.data(), buffer.size(), 0) < 0) continue;
      std::int64_t left = 0;
      std::memcpy(&left, buffer.data(), sizeof left);
      const std::lock_guard lock(mutex_);
      one_way_us_.push_back(static_cast<double>(now_ns() - left) * 1e-3);
    }
  }
  std::vector<char> datagram_;
  const int in_{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  const int out_{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  std::mutex mutex_;
  std::vector<double> one_way_us_{};
  std::atomic<bool> running_{true};
  std::thread thread_{};
};

}  // namespace

void udp_one_way(int blocks) {
  Path path;
  RawUdp raw(path.datagram_size());
  print(compare(
      "sample -> mailbox one way by UDP p50",
      "raw UDP of " + std::to_string(path.datagram_size()) + " bytes", "us",
      [&] { return path.block(); }, [&] { return raw.block(); }, 1.6, blocks));
}

}  // namespace haptic::bench
