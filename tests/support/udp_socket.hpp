#pragma once
/// A UDP socket on a port of 127.0.0.1 that the kernel chose.

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>

namespace haptic::test {

class UdpSocket {
 public:
  UdpSocket() {
    sockaddr_in own = loopback(0);
    socklen_t size = sizeof own;
    if (::bind(socket_, reinterpret_cast<sockaddr*>(&own), size) != 0 ||
        ::getsockname(socket_, reinterpret_cast<sockaddr*>(&own), &size) != 0) {
      throw std::runtime_error("no loopback socket");
    }
    port_ = ntohs(own.sin_port);
  }
  ~UdpSocket() { ::close(socket_); }
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// Returns false if the datagram did not leave.
  bool send(std::span<const std::uint8_t> datagram, std::uint16_t port) const {
    const sockaddr_in to = loopback(port);
    const ssize_t sent = ::sendto(socket_, datagram.data(), datagram.size(), 0,
                                  reinterpret_cast<const sockaddr*>(&to), sizeof to);
    return sent == static_cast<ssize_t>(datagram.size());
  }
  /// Waits until a datagram is there, or so long.
  void wait(int milliseconds) const {
    pollfd waiting{socket_, POLLIN, 0};
    ::poll(&waiting, 1, milliseconds);
  }
  struct Received {
    std::size_t size{0};
    std::uint16_t from{0};  ///< the sender's port
  };
  /// The next datagram, cut to `buffer`, without waiting; none if none is there.
  [[nodiscard]] std::optional<Received> receive(std::span<std::uint8_t> buffer) const {
    sockaddr_in from{};
    socklen_t length = sizeof from;
    const ssize_t size = ::recvfrom(socket_, buffer.data(), buffer.size(), MSG_DONTWAIT,
                                    reinterpret_cast<sockaddr*>(&from), &length);
    if (size < 0) return std::nullopt;
    return Received{static_cast<std::size_t>(size), ntohs(from.sin_port)};
  }

 private:
  static sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
  }

  const int socket_{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  std::uint16_t port_{0};
};

}  // namespace haptic::test
