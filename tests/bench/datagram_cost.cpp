#include <array>
#include <stdexcept>

#include "haptic/wire/secure_channel.hpp"
#include "server/ingress/ingress.hpp"
#include "server/rpc/convert.hpp"
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

using Step = void (Way::*)(int);
constexpr std::array<Step, 4> kSteps{&Way::receive, &Way::open, &Way::parse, &Way::accept};

double ns_per_datagram(std::chrono::steady_clock::duration time) {
  return std::chrono::duration<double, std::nano>(time).count() / (kRounds * kWaiting);
}

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
}

}  // namespace haptic::bench
