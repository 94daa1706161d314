#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "haptic/wire/secure_channel.hpp"
#include "server/front/link_watch.hpp"
#include "server/front/sample_ledger.hpp"
#include "server/ingress/ingress.hpp"
#include "server/rpc/convert.hpp"
#include "server/udp/udp_path.hpp"
#include "server/udp/udp_socket.hpp"
#include "tests/bench/network.hpp"
#include "tests/bench/network_sample.hpp"
#include "tests/bench/paired.hpp"

namespace haptic::bench {
namespace {

using std::chrono::milliseconds;

/// Datagrams that wait when their receiving is timed; a default socket buffer holds twice that.
constexpr int kWaiting = 100;
constexpr int kRounds = 20;  ///< per block

double ns_per_datagram(std::chrono::steady_clock::duration time) {
  return std::chrono::duration<double, std::nano>(time).count() / (kRounds * kWaiting);
}

/// Everything that a datagram meets on its way to the mailbox, step by step.
class Way {
 public:
  Way()
      : receiver_(context_, "127.0.0.1:0"),
        sender_(context_, "127.0.0.1:0"),
        keys_(wire::fresh_keys()),
        client_(wire::End::kClient, keys_),
        server_(wire::End::kServer, keys_),
        ingress_(mailbox_, 2) {
    to_.port = receiver_.bound().port();
    const auto host = receiver_.bound().address().to_v4();
    const auto bytes = asio::ip::make_address_v6(asio::ip::v4_mapped, host).to_bytes();
    std::copy(bytes.begin(), bytes.end(), to_.ip.begin());
    ingress_.begin_lease(1, 1000.0, milliseconds(100));
  }

  /// Puts `kWaiting` fresh datagrams into the socket.
  void send() {
    for (int i = 0; i < kWaiting; ++i) {
      v1::ProxySample sample;
      fill(sample, ++seq_);
      const std::string text = sample.SerializeAsString();
      const wire::ConstBytes payload(reinterpret_cast<const std::uint8_t*>(text.data()),
                                     text.size());
      std::array<std::uint8_t, wire::kLargestDatagram> out{};
      const std::size_t size = client_.seal(wire::DatagramType::kProxy, payload, out);
      sender_.send(to_, wire::ConstBytes(out).first(size));
    }
  }
  void receive(int i) {
    const server::Arrived arrived = receiver_.receive(datagram_[at(i)]);
    if (!arrived.any) throw std::runtime_error("a datagram on loopback was lost");
    size_[at(i)] = arrived.size;
  }
  void open(int i) {
    now_ += milliseconds(1);
    const auto opened = server_.open(wire::ConstBytes(datagram_[at(i)]).first(size_[at(i)]),
                                     payload_[at(i)], wire::TimePoint(now_.time_since_epoch()));
    if (opened.rejection != wire::Rejection::kNone) throw std::runtime_error("rejected");
    payload_size_[at(i)] = opened.size;
  }
  void parse(int i) {
    if (!sample_[at(i)].ParseFromArray(payload_[at(i)].data(),
                                       static_cast<int>(payload_size_[at(i)]))) {
      throw std::runtime_error("no sample");
    }
  }
  void accept(int i) {
    arrival_ += milliseconds(1);
    const auto verdict =
        ingress_.accept(server::from_proto(sample_[at(i)], 1, server::Carrier::kUdp), arrival_);
    if (verdict != server::IngressVerdict::kAccepted) throw std::runtime_error("not accepted");
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  asio::io_context context_{1};
  server::UdpSocket receiver_, sender_;
  wire::PeerAddress to_{};
  wire::PathKeys keys_;
  wire::SecureChannel client_, server_;
  core::Mailbox<core::ProxySnapshot> mailbox_{};
  server::Ingress ingress_;
  std::uint64_t seq_{0};
  core::TimePoint now_{std::chrono::hours(1)}, arrival_{std::chrono::hours(1)};
  std::array<std::array<std::uint8_t, wire::kLargestDatagram + 1>, kWaiting> datagram_{};
  std::array<std::array<std::uint8_t, wire::kLargestPayload>, kWaiting> payload_{};
  std::array<std::size_t, kWaiting> size_{}, payload_size_{};
  std::array<v1::ProxySample, kWaiting> sample_{};
};

/// What a session does with a sample that came by UDP, of the server's own parts: the figures of the
/// link, the client's clock, the door, the ledger (SessionStream::take_sample without gRPC).
class Session final : public server::UdpSink {
 public:
  Session() : ingress_(mailbox_, 2) { ingress_.begin_lease(1, 1000.0, milliseconds(100)); }

  void state_sent(std::uint64_t tick, core::TimePoint at) {
    link_.state_sent(tick, at, server::Carrier::kUdp);
  }
  void on_udp_sample(const v1::ProxySample& sample, core::TimePoint arrival) override {
    const server::SampleStamp stamp{server::Carrier::kUdp,
                                    sample.ByteSizeLong(),
                                    sample.source_time_ns(),
                                    sample.device_seq_used(),
                                    std::chrono::microseconds(sample.hold_us()),
                                    arrival};
    server::ProxyCandidate candidate = server::from_proto(sample, 1, server::Carrier::kUdp);
    candidate.left = link_.came(stamp, path->clock(arrival));
    const auto verdict = ingress_.accept(candidate, arrival, &why_);
    if (verdict != server::IngressVerdict::kAccepted) throw std::runtime_error("not accepted");
    link_.judged(server::Carrier::kUdp, verdict);
    ledger_.book(sample.seq(), verdict, std::string());
  }
  void on_udp_change(wire::PathChange) override {}
  void on_udp_keys(const wire::PathKeys&) override {}

  std::shared_ptr<server::UdpPath> path{};

 private:
  core::Mailbox<core::ProxySnapshot> mailbox_{};
  server::Ingress ingress_;
  server::LinkWatch link_{};
  server::SampleLedger ledger_{};
  std::string why_{};
};

/// Of one datagram all that the server does, from the path on: locks, window, AEAD, figures, parse,
/// clock, ingress, ledger. Datagrams are 1 ms apart, on a clock that the measurement turns.
class WholePath {
 public:
  WholePath() : keys_(wire::fresh_keys()), client_(wire::End::kClient, keys_) {
    wire::PathEndSetup setup;
    setup.end = wire::End::kServer;
    setup.keys = keys_;
    setup.send = [](const wire::PeerAddress&, wire::ConstBytes) {};
    session_->path = std::make_shared<server::UdpPath>(std::move(setup), session_);
  }
  ~WholePath() { session_->path.reset(); }
  WholePath(const WholePath&) = delete;
  WholePath& operator=(const WholePath&) = delete;

  double block() {
    std::chrono::steady_clock::duration time{0};
    for (int round = 0; round < kRounds; ++round) {
      core::TimePoint arrival = now_;
      for (auto& datagram : datagrams_) datagram = sealed(arrival += milliseconds(1));
      const auto start = std::chrono::steady_clock::now();
      for (const auto& datagram : datagrams_) {
        now_ += milliseconds(1);
        if (session_->path->receive(datagram, {}, now_) != wire::Rejection::kNone) {
          throw std::runtime_error("rejected");
        }
      }
      time += std::chrono::steady_clock::now() - start;
    }
    return ns_per_datagram(time);
  }

 private:
  std::vector<std::uint8_t> sealed(core::TimePoint arrival) {
    v1::ProxySample sample;
    fill(sample, ++seq_);
    const auto left = arrival - std::chrono::microseconds(100);
    sample.set_source_time_ns(left.time_since_epoch().count());
    session_->state_sent(sample.device_seq_used(), left - std::chrono::microseconds(4100));
    const std::string text = sample.SerializeAsString();
    std::vector<std::uint8_t> out(wire::kLargestDatagram);
    out.resize(client_.seal(
        wire::DatagramType::kProxy,
        wire::ConstBytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()), out));
    return out;
  }

  wire::PathKeys keys_;
  wire::SecureChannel client_;
  std::shared_ptr<Session> session_ = std::make_shared<Session>();
  std::uint64_t seq_{0};
  core::TimePoint now_{std::chrono::hours(1)};
  std::array<std::vector<std::uint8_t>, kWaiting> datagrams_{};
};

using Step = void (Way::*)(int);
constexpr std::array<Step, 4> kSteps{&Way::receive, &Way::open, &Way::parse, &Way::accept};

/// Time of step `timed` per datagram in one block; all the others are done around it.
double step_block(Way& way, std::size_t timed) {
  std::chrono::steady_clock::duration time{0};
  for (int round = 0; round < kRounds; ++round) {
    way.send();
    for (std::size_t step = 0; step < kSteps.size(); ++step) {
      const auto start = std::chrono::steady_clock::now();
      for (int i = 0; i < kWaiting; ++i) (way.*kSteps[step])(i);
      if (step == timed) time += std::chrono::steady_clock::now() - start;
    }
  }
  return ns_per_datagram(time);
}

double all_block(Way& way) {
  std::chrono::steady_clock::duration time{0};
  for (int round = 0; round < kRounds; ++round) {
    way.send();
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < kWaiting; ++i) {
      for (const Step step : kSteps) (way.*step)(i);
    }
    time += std::chrono::steady_clock::now() - start;
  }
  return ns_per_datagram(time);
}

}  // namespace

void datagram_cost(int blocks) {
  const auto way = std::make_unique<Way>();
  constexpr std::array<const char*, 4> kNames{"one datagram: receive",
                                              "one datagram: AEAD and window",
                                              "one datagram: parse", "one datagram: ingress"};
  for (std::size_t step = 0; step < kSteps.size(); ++step) {
    print(measure(
        kNames[step], "ns", [&] { return step_block(*way, step); }, 0.0, blocks));
  }
  print(measure(
      "one datagram: all of it", "ns", [&] { return all_block(*way); }, 3000.0, blocks));
  WholePath whole;
  print(measure(
      "one datagram: from the path to the mailbox, with locks, figures, clock and ledger", "ns",
      [&] { return whole.block(); }, 3000.0, blocks));
}

}  // namespace haptic::bench
