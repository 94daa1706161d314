#pragma once
/// A bound UDP socket that never blocks, with the kernel's time of arrival (private to server/udp).

#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>

#include <string>

#include "haptic/core/time.hpp"
#include "haptic/wire/datagram.hpp"
#include "haptic/wire/path_machine.hpp"

namespace haptic::server {

struct Arrived {
  bool any{false};      ///< false: nothing is waiting
  std::size_t size{0};  ///< above the buffer's size if the datagram was cut
  wire::PeerAddress from{};
  core::Duration waited{0};  ///< in the socket: since the kernel got it
};

class UdpSocket {
 public:
  /// `listen`: "host:port" or "[v6]:port"; port 0: any free one. Throws TransportError.
  UdpSocket(asio::io_context& context, const std::string& listen);

  [[nodiscard]] Arrived receive(wire::Bytes buffer) noexcept;
  /// Any thread. A datagram that the kernel has no room for is dropped: the next one is newer.
  void send(const wire::PeerAddress& to, wire::ConstBytes datagram) noexcept;

  [[nodiscard]] asio::ip::udp::endpoint bound() const { return bound_; }
  [[nodiscard]] asio::ip::udp::socket& waitable() noexcept { return socket_; }

 private:
  asio::ip::udp::socket socket_;
  asio::ip::udp::endpoint bound_;
};

}  // namespace haptic::server
