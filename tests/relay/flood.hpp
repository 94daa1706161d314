#pragma once
/// 100 000 datagrams per second to a port of 127.0.0.1, from a thread.

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

#include "tests/support/link/impaired_link.hpp"
#include "tests/support/udp_socket.hpp"

namespace haptic::test {

/// A UDP socket on 127.0.0.1 that throws away what it gets, as fast as it can.
class DiscardingSocket {
 public:
  DiscardingSocket();
  ~DiscardingSocket();
  DiscardingSocket(const DiscardingSocket&) = delete;
  DiscardingSocket& operator=(const DiscardingSocket&) = delete;
  [[nodiscard]] std::uint16_t port() const { return socket_.port(); }

 private:
  const UdpSocket socket_{};
  std::atomic<bool> running_{true};
  std::thread thread_{};
};

class Flood {
 public:
  static constexpr std::uint64_t kPerMillisecond = 100;

  /// Sends `packets` in turn until it is destroyed.
  Flood(std::uint16_t port, std::vector<Packet> packets);
  ~Flood();
  Flood(const Flood&) = delete;
  Flood& operator=(const Flood&) = delete;

  /// Ends it.
  void stop();
  [[nodiscard]] std::uint64_t sent() const { return sent_; }
  /// Anything came back to the socket it is sent from.
  [[nodiscard]] bool answered() const;

 private:
  void run(std::uint16_t port);

  const std::vector<Packet> packets_;
  const UdpSocket socket_{};
  std::atomic<std::uint64_t> sent_{0};
  std::atomic<bool> running_{true};
  std::thread thread_{};
};

/// 500 datagrams of any bytes and any length up to 1300.
[[nodiscard]] std::vector<Packet> junk();
/// 500 with a valid PROXY header of `path_id` and random bytes for a payload.
[[nodiscard]] std::vector<Packet> headed(std::uint32_t path_id);

}  // namespace haptic::test
