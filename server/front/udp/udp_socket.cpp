#include "server/front/udp/udp_socket.hpp"

#include <sys/socket.h>
#include <sys/uio.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "haptic/core/error.hpp"
#include "server/base/steady_now.hpp"

namespace haptic::server {
namespace {

using asio::ip::udp;

/// Room for a tenth of a second of a flood: more would only grow old in there.
constexpr int kReceiveBuffer = 1 << 20;

wire::PeerAddress peer(const udp::endpoint& endpoint) {
  wire::PeerAddress answer;
  const asio::ip::address address = endpoint.address();
  answer.ip = address.is_v6()
                  ? address.to_v6().to_bytes()
                  : asio::ip::make_address_v6(asio::ip::v4_mapped, address.to_v4()).to_bytes();
  answer.port = endpoint.port();
  return answer;
}

udp::endpoint endpoint(const wire::PeerAddress& peer, bool v4) {
  const asio::ip::address_v6 address(peer.ip);
  if (v4 && address.is_v4_mapped()) {
    return {asio::ip::make_address_v4(asio::ip::v4_mapped, address), peer.port};
  }
  return {address, peer.port};
}

/// How long ago the kernel stamped the datagram, by the wall clock. Below 0 without a stamp.
core::Duration age_of_stamp(msghdr& message) {
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
    if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec stamp{}, now{};
    std::memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
    ::clock_gettime(CLOCK_REALTIME, &now);
    return std::chrono::seconds(now.tv_sec - stamp.tv_sec) +
           std::chrono::nanoseconds(now.tv_nsec - stamp.tv_nsec);
  }
  return core::Duration(-1);
}

}  // namespace

UdpSocket::UdpSocket(asio::io_context& context, Descriptor bound)
    : socket_(context), empty_at_(steady_now()) {
  sockaddr_storage name{};
  socklen_t size = sizeof name;
  const int on = 1;
  if (getsockname(bound.get(), reinterpret_cast<sockaddr*>(&name), &size) != 0 ||
      setsockopt(bound.get(), SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) != 0) {
    throw core::TransportError(std::string("UDP socket: ") + std::strerror(errno));
  }
  socket_.assign(name.ss_family == AF_INET6 ? udp::v6() : udp::v4(), bound.release());
  socket_.non_blocking(true);
  asio::error_code ignored;
  socket_.set_option(asio::socket_base::receive_buffer_size(kReceiveBuffer), ignored);
  bound_ = socket_.local_endpoint();
}

Arrived UdpSocket::receive(wire::Bytes buffer) noexcept {
  udp::endpoint from;
  iovec part{buffer.data(), buffer.size()};
  alignas(cmsghdr) std::array<std::uint8_t, 64> control{};
  msghdr message{};
  message.msg_name = from.data();
  message.msg_namelen = static_cast<socklen_t>(from.capacity());
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  // MSG_TRUNC: the true size of a datagram that is too long, so that it is rejected for its length.
  const core::TimePoint asked = steady_now();
  const ssize_t size = ::recvmsg(socket_.native_handle(), &message, MSG_DONTWAIT | MSG_TRUNC);
  if (size < 0) {
    empty_at_ = asked;
    return {};
  }
  from.resize(message.msg_namelen);
  return {true, static_cast<std::size_t>(size), peer(from),
          believed_wait(age_of_stamp(message), steady_now() - empty_at_)};
}

void UdpSocket::send(const wire::PeerAddress& to, wire::ConstBytes datagram) noexcept {
  const udp::endpoint target = endpoint(to, bound_.address().is_v4());
  static_cast<void>(::sendto(socket_.native_handle(), datagram.data(), datagram.size(),
                             MSG_DONTWAIT | MSG_NOSIGNAL, target.data(),
                             static_cast<socklen_t>(target.size())));
}

}  // namespace haptic::server
