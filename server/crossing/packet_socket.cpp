#include "server/crossing/packet_socket.hpp"

#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <string>
#include <thread>

#include "haptic/core/error.hpp"
#include "server/base/thread_setup.hpp"

namespace haptic::server {
namespace {

std::atomic<int> closing{0};

/// recvmsg() without waiting.
ssize_t take(int socket, msghdr& message, int flags) noexcept {
  ssize_t got = 0;
  do {
    got = recvmsg(socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC | flags);
  } while (got < 0 && errno == EINTR);
  return got;
}

}  // namespace

std::pair<Descriptor, Descriptor> packet_pair() {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0) {
    throw core::TransportError(std::string("socketpair: ") + std::strerror(errno));
  }
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

void refuse_descriptors(int socket) noexcept {
  const int off = 0;
  setsockopt(socket, SOL_SOCKET, kPassRights, &off, sizeof off);
}

bool send_bytes(int socket, Bytes head, Bytes rest, std::span<const int> descriptors) {
  if (descriptors.size() > kMostDescriptors) return false;
  std::array<iovec, 2> parts{iovec{const_cast<std::byte*>(head.data()), head.size()},
                             iovec{const_cast<std::byte*>(rest.data()), rest.size()}};
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof(int) * kMostDescriptors)> control{};
  msghdr message{};
  message.msg_iov = parts.data();
  message.msg_iovlen = parts.size();
  if (!descriptors.empty()) {
    message.msg_control = control.data();
    message.msg_controllen = CMSG_SPACE(descriptors.size_bytes());
    cmsghdr* const header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(descriptors.size_bytes());
    std::memcpy(CMSG_DATA(header), descriptors.data(), descriptors.size_bytes());
  }
  ssize_t sent = 0;
  do {
    sent = sendmsg(socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
  } while (sent < 0 && errno == EINTR);
  return sent == static_cast<ssize_t>(head.size() + rest.size());
}

Next look_at_next(int socket) noexcept {
  Next next;
  iovec part{&next.word, sizeof next.word};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  const ssize_t got = take(socket, message, MSG_PEEK | MSG_TRUNC);
  if (got < 0 && errno == EAGAIN) return next;
  next.bytes = got > 0 ? static_cast<std::size_t>(got) : 0;
  const bool burdened = (message.msg_flags & MSG_CTRUNC) != 0;  // there is no room for descriptors
  next.what = burdened ? Received::kBurdened : got > 0 ? Received::kMessage : Received::kGone;
  return next;
}

std::ptrdiff_t take_bytes(int socket, std::span<std::byte> head, std::span<std::byte> rest) {
  std::array<iovec, 2> parts{iovec{head.data(), head.size()}, iovec{rest.data(), rest.size()}};
  msghdr message{};
  message.msg_iov = parts.data();
  message.msg_iovlen = parts.size();
  return take(socket, message, 0);
}

Received receive_bytes(int socket, std::span<std::byte> bytes,
                       std::vector<Descriptor>* descriptors) {
  if (descriptors == nullptr) {
    const Next next = look_at_next(socket);
    if (next.what != Received::kMessage) return next.what;
    const bool whole = take_bytes(socket, bytes) == static_cast<ssize_t>(bytes.size());
    return whole && next.bytes == bytes.size() ? Received::kMessage : Received::kOdd;
  }
  iovec part{bytes.data(), bytes.size()};
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof(int) * kMostDescriptors)> control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t got = take(socket, message, 0);
  if (got < 0) return errno == EAGAIN ? Received::kNothing : Received::kGone;
  std::vector<Descriptor> brought;
  for (cmsghdr* header = CMSG_FIRSTHDR(&message); header != nullptr;
       header = CMSG_NXTHDR(&message, header)) {
    if (header->cmsg_level != SOL_SOCKET || header->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t count = (header->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < count; ++i) {
      int fd = -1;
      std::memcpy(&fd, CMSG_DATA(header) + i * sizeof(int), sizeof(int));
      brought.emplace_back(fd);  // closed here unless the caller wants it
    }
  }
  if (got == 0) return Received::kGone;
  if (static_cast<std::size_t>(got) != bytes.size() || (message.msg_flags & MSG_TRUNC) != 0) {
    return Received::kOdd;
  }
  *descriptors = std::move(brought);
  return Received::kMessage;
}

void close_aside(Descriptor socket) noexcept {
  shutdown(socket.get(), SHUT_RD);  // from now on it gets nothing more
  for (int i = 0; i < 2'000; ++i) {
    const Next next = look_at_next(socket.get());
    if (next.what == Received::kBurdened) break;
    if (next.what != Received::kMessage) return;  // it is empty
    static_cast<void>(take_bytes(socket.get(), {}));
  }
  const int number = socket.release();
  ++closing;
  try {
    std::thread([number] {
      set_thread_up("close aside");
      close(number);
      --closing;
    }).detach();
  } catch (...) {  // no thread is to be had: the socket stays open
  }
}

int closing_aside() noexcept {
  return closing.load();
}

}  // namespace haptic::server
