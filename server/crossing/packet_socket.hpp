#pragma once
/// Whole messages between two processes: a pair of connected UNIX sockets of type SOCK_SEQPACKET.
/// A message is one trivially copyable value, and may bring descriptors.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/crossing/shared_memory.hpp"

namespace haptic::server {

enum class Received : std::uint8_t {
  kMessage,
  kNothing,  ///< none is there yet
  kOdd,      ///< a message of another size, which was thrown away
  kGone,     ///< the other end is closed
};

/// Two ends that do not block and are closed by exec. Throws core::TransportError.
[[nodiscard]] std::pair<Descriptor, Descriptor> packet_pair();

/// False: the other end is gone, its queue is full, or there are more than kMostDescriptors.
bool send_bytes(int socket, std::span<const std::byte> bytes, std::span<const int> descriptors);
/// Descriptors beyond kMostDescriptors are closed.
[[nodiscard]] Received receive_bytes(int socket, std::span<std::byte> bytes,
                                     std::vector<Descriptor>* descriptors);
inline constexpr std::size_t kMostDescriptors = 253;  // the kernel's SCM_MAX_FD

template <typename T>
bool send(int socket, const T& message, std::span<const int> descriptors = {}) {
  static_assert(std::is_trivially_copyable_v<T>);
  return send_bytes(socket, std::as_bytes(std::span(&message, 1)), descriptors);
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
