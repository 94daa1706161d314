#pragma once
/// One end of a UDP path on a real loopback socket, with its own thread: the plainest client or
/// server, on wire::PathEnd alone.

#include <atomic>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "haptic/wire/path_end.hpp"
#include "tests/support/udp_socket.hpp"

namespace haptic::test {

class UdpEnd {
 public:
  /// A client of `server_port` on 127.0.0.1; a server (0) answers any client.
  UdpEnd(wire::End end, const wire::PathKeys& keys, std::uint16_t server_port = 0);
  ~UdpEnd();
  UdpEnd(const UdpEnd&) = delete;
  UdpEnd& operator=(const UdpEnd&) = delete;

  [[nodiscard]] std::uint16_t port() const { return socket_.port(); }
  /// Sends by UDP, if the path is in use.
  bool send(const std::string& message);
  /// Any bytes, to a port of 127.0.0.1, from this end's socket.
  void send_raw(const std::vector<std::uint8_t>& bytes, std::uint16_t port);
  /// Bytes that send() would put on the wire for `type`, without sending it.
  [[nodiscard]] std::vector<std::uint8_t> seal(const std::string& message);
  void rekey(const wire::PathKeys& keys);

  [[nodiscard]] bool in_use() const;
  [[nodiscard]] std::vector<std::string> messages() const;
  [[nodiscard]] wire::LinkCounters counters() const;
  /// Datagrams that came in, whatever they were.
  [[nodiscard]] std::size_t arrivals() const { return arrivals_; }

  /// Nothing gets in or out any more.
  std::atomic<bool> cut{false};

 private:
  void run();
  void take(wire::ConstBytes bytes, std::uint16_t from);

  UdpSocket socket_{};
  mutable std::mutex mutex_;
  std::vector<std::uint8_t>* caught_{nullptr};  ///< takes the next datagram, for seal()
  wire::PathEnd end_;
  std::vector<std::string> messages_{};
  std::atomic<std::size_t> arrivals_{0};
  std::atomic<bool> running_{true};
  std::thread thread_{};
};

}  // namespace haptic::test
