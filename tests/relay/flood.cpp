#include "tests/relay/flood.hpp"

#include <array>

#include "haptic/wire/datagram.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;
constexpr std::size_t kPackets = 500;

}  // namespace

DiscardingSocket::DiscardingSocket() {
  thread_ = std::thread([this] {
    std::array<std::uint8_t, 2048> buffer{};
    while (running_) {
      socket_.wait(20);
      while (socket_.receive(buffer)) {
      }
    }
  });
}

DiscardingSocket::~DiscardingSocket() {
  running_ = false;
  thread_.join();
}

Flood::Flood(std::uint16_t port, std::vector<Packet> packets) : packets_(std::move(packets)) {
  thread_ = std::thread([this, port] { run(port); });
}

Flood::~Flood() {
  stop();
}

void Flood::stop() {
  running_ = false;
  if (thread_.joinable()) thread_.join();
}

/// In bursts of a tenth of a millisecond's share; a late wake-up sends what is due by then.
void Flood::run(std::uint16_t port) {
  const auto begin = std::chrono::steady_clock::now();
  while (running_) {
    const auto due = static_cast<std::uint64_t>((std::chrono::steady_clock::now() - begin) / 1us) *
                     kPerMillisecond / 1000;
    while (running_ && sent_ < due) {
      static_cast<void>(socket_.send(packets_[sent_ % packets_.size()], port));
      ++sent_;
    }
    std::this_thread::sleep_for(100us);
  }
}

bool Flood::answered() const {
  std::array<std::uint8_t, 1> byte{};
  return socket_.receive(byte).has_value();
}

std::vector<Packet> junk() {
  Random random(5);
  std::vector<Packet> packets(kPackets);
  for (Packet& packet : packets) {
    packet.resize(1 + random.next() % 1300);
    for (auto& byte : packet) byte = static_cast<std::uint8_t>(random.next());
    if (packet.front() == wire::kMagicBytes.front()) packet.front() = 0;  // junk for certain
  }
  return packets;
}

std::vector<Packet> headed(std::uint32_t path_id) {
  Random random(6);
  std::vector<Packet> packets(kPackets);
  for (std::size_t i = 0; i < packets.size(); ++i) {
    packets[i].resize(32 + random.next() % 200);
    for (auto& byte : packets[i]) byte = static_cast<std::uint8_t>(random.next());
    // Far ahead of the genuine ones, so that only the tag can tell.
    wire::write_header({wire::DatagramType::kProxy, path_id, 1'000'000'000 + i},
                       std::span<std::uint8_t, wire::kHeaderSize>(packets[i].data(), 16));
  }
  return packets;
}

}  // namespace haptic::test
