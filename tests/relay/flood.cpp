#include "tests/relay/flood.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "haptic/wire/datagram.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;
constexpr std::size_t kPackets = 500;

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

}  // namespace

DiscardingSocket::DiscardingSocket() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in own = loopback(0);
  socklen_t size = sizeof own;
  if (::bind(socket_, reinterpret_cast<sockaddr*>(&own), size) != 0 ||
      ::getsockname(socket_, reinterpret_cast<sockaddr*>(&own), &size) != 0) {
    throw std::runtime_error("no loopback socket");
  }
  port_ = ntohs(own.sin_port);
  thread_ = std::thread([this] {
    char buffer[2048];
    while (running_) {
      pollfd waiting{socket_, POLLIN, 0};
      ::poll(&waiting, 1, 20);
      while (::recv(socket_, buffer, sizeof buffer, MSG_DONTWAIT) >= 0) {
      }
    }
  });
}

DiscardingSocket::~DiscardingSocket() {
  running_ = false;
  thread_.join();
  ::close(socket_);
}

Flood::Flood(std::uint16_t port, std::vector<Packet> packets, std::uint64_t limit)
    : packets_(std::move(packets)), socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  const sockaddr_in to = loopback(port);
  if (::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
    throw std::runtime_error("no loopback socket");
  }
  thread_ = std::thread([this, limit] { run(limit); });
}

Flood::~Flood() {
  stop();
  ::close(socket_);
}

void Flood::stop() {
  running_ = false;
  if (thread_.joinable()) thread_.join();
}

/// In bursts of a tenth of a millisecond's worth and more; what a late wake-up missed is caught up.
void Flood::run(std::uint64_t limit) {
  const auto begin = std::chrono::steady_clock::now();
  while (running_ && sent_ < limit) {
    const auto due = static_cast<std::uint64_t>((std::chrono::steady_clock::now() - begin) / 1us) *
                     kPerMillisecond / 1000;
    while (running_ && sent_ < std::min(due, limit)) {
      const Packet& packet = packets_[sent_ % packets_.size()];
      // An error is the echo of a port that nobody reads, told once; the next one goes.
      static_cast<void>(::send(socket_, packet.data(), packet.size(), 0));
      ++sent_;
    }
    std::this_thread::sleep_for(100us);
  }
  done_ = true;
}

bool Flood::answered() const {
  char byte = 0;
  return ::recv(socket_, &byte, 1, MSG_DONTWAIT) >= 0;
}

std::uint64_t dropped_by_kernel(std::uint16_t port) {
  std::ifstream table("/proc/net/udp");
  std::string line;
  std::getline(table, line);
  while (std::getline(table, line)) {
    std::istringstream fields(line);
    std::vector<std::string> all;
    for (std::string field; fields >> field;) all.push_back(field);
    const std::size_t colon = all.at(1).find(':');
    if (std::stoul(all[1].substr(colon + 1), nullptr, 16) == port) return std::stoull(all.back());
  }
  throw std::runtime_error("no UDP socket on port " + std::to_string(port));
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
