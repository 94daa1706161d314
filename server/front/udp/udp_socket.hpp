#pragma once
/// A bound UDP socket that never blocks, with the kernel's time of arrival (private to
/// server/front/udp).

#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>

#include "haptic/core/time.hpp"
#include "haptic/wire/datagram.hpp"
#include "haptic/wire/path_machine.hpp"
#include "server/base/descriptor.hpp"

namespace haptic::server {

/// How long a datagram waited in the socket. `by_stamp` is what the kernel's stamp says; it comes
/// from the wall clock, which may be stepped, by 5 s for example, while the datagram waits.
/// `since_empty` is the time since the socket was seen empty, on the steady clock: the datagram
/// cannot have waited for longer. A stamp from the future tells nothing, so that the longest
/// possible time counts.
[[nodiscard]] constexpr core::Duration believed_wait(core::Duration by_stamp,
                                                     core::Duration since_empty) noexcept {
  return by_stamp < core::Duration(0) || by_stamp > since_empty ? since_empty : by_stamp;
}

struct Arrived {
  bool any{false};      ///< false: nothing is waiting
  std::size_t size{0};  ///< above the buffer's size if the datagram was cut
  wire::PeerAddress from{};
  core::Duration waited{0};  ///< in the socket: since the kernel got it
};

class UdpSocket {
 public:
  /// `bound`: a socket that is. Throws core::TransportError.
  UdpSocket(asio::io_context& context, Descriptor bound);

  [[nodiscard]] Arrived receive(wire::Bytes buffer) noexcept;
  /// Any thread. A datagram that the kernel has no room for is dropped: the next one is newer.
  void send(const wire::PeerAddress& to, wire::ConstBytes datagram) noexcept;

  [[nodiscard]] asio::ip::udp::endpoint bound() const { return bound_; }
  [[nodiscard]] asio::ip::udp::socket& waitable() noexcept { return socket_; }

 private:
  asio::ip::udp::socket socket_;
  asio::ip::udp::endpoint bound_;
  core::TimePoint empty_at_;  ///< the socket was last seen empty
};

}  // namespace haptic::server
