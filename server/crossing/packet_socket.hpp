#pragma once
/// Whole messages between two processes: a pair of connected UNIX sockets of type SOCK_SEQPACKET.
/// A message is one trivially copyable value, and may bring descriptors. Each process holds one
/// end, and nothing that the other one does to its own end makes a call here wait.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/base/descriptor.hpp"

namespace haptic::server {

enum class Received : std::uint8_t {
  kMessage,
  kNothing,   ///< none is there yet
  kOdd,       ///< a message of another size, which was thrown away
  kBurdened,  ///< the message brings descriptors that the caller does not want; it stays there
  kGone,      ///< the other end is closed
};

/// Two ends that do not block and are closed by exec. Throws core::TransportError.
[[nodiscard]] std::pair<Descriptor, Descriptor> packet_pair();

/// From Linux 6.16 on; its headers may be older.
inline constexpr int kPassRights = 83;  // SO_PASSRIGHTS
/// No descriptors may be sent to this UNIX socket, or to connections of this listener: gRPC drops
/// those that come, and the last close of a socket takes as long as its sender likes (SO_LINGER).
/// Two such messages would hold up all its threads. An older kernel cannot refuse them.
void refuse_descriptors(int socket) noexcept;

using Bytes = std::span<const std::byte>;
/// One message of two parts. False: the other end is gone, its queue is full (EAGAIN), or there are
/// more than kMostDescriptors.
bool send_bytes(int socket, Bytes head, Bytes rest = {}, std::span<const int> descriptors = {});
inline constexpr std::size_t kMostDescriptors = 253;  // the kernel's SCM_MAX_FD

/// The message that comes next, which stays there.
struct Next {
  Received what{Received::kNothing};  ///< kMessage, kNothing, kBurdened or kGone
  std::size_t bytes{0};
  std::uint64_t word{0};  ///< that it begins with
};
[[nodiscard]] Next look_at_next(int socket) noexcept;

/// Takes a message of two parts; its size, or -1. Only after look_at_next() said kMessage: the
/// descriptor that a message brings is closed by whom it reaches last, and to close one may wait
/// for as long as its sender likes (SO_LINGER).
std::ptrdiff_t take_bytes(int socket, std::span<std::byte> head, std::span<std::byte> rest = {});

/// `descriptors` are what the message brought, those beyond kMostDescriptors are closed; null: only
/// a message that brings none is taken.
[[nodiscard]] Received receive_bytes(int socket, std::span<std::byte> bytes,
                                     std::vector<Descriptor>* descriptors);

/// Closes the socket of an untrusted process. What it still holds is closed with it, which may wait
/// (take_bytes()): then a thread of its own does it.
void close_aside(Descriptor socket) noexcept;
/// Threads that close_aside() waits for.
[[nodiscard]] int closing_aside() noexcept;

template <typename T>
[[nodiscard]] Bytes bytes_of(const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  return std::as_bytes(std::span(&value, 1));
}

template <typename T>
bool send(int socket, const T& message, std::span<const int> descriptors = {}) {
  return send_bytes(socket, bytes_of(message), {}, descriptors);
}

/// `message` is only changed by kMessage. Its bytes are the sender's: the caller checks them.
template <typename T>
[[nodiscard]] Received receive(int socket, T& message,
                               std::vector<Descriptor>* descriptors = nullptr) {
  static_assert(std::is_trivially_copyable_v<T>);
  T copy;
  const Received got =
      receive_bytes(socket, std::as_writable_bytes(std::span(&copy, 1)), descriptors);
  if (got == Received::kMessage) message = copy;
  return got;
}

}  // namespace haptic::server
