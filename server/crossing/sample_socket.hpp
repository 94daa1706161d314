#pragma once
/// A front's second socket to the owner: samples, and stops, which wait behind no other request.
/// A message is its kind and the bytes of one value, of a proxy's sample only as many as it has
/// planes. The owner reads it on the link's thread alone: to take a message out wakes the front's
/// threads, and how many wait for that is the front's to say.

#include "server/crossing/crossing.hpp"
#include "server/crossing/packet_socket.hpp"

namespace haptic::server {

enum class SampleKind : std::uint64_t { kProxy = 1, kPose, kStopAhead };

/// A stop of the device, ahead of its request, which waits for the requests before it.
struct StopAhead {
  std::uint32_t device{0};
  Text<200> why{};
};
static_assert(any_bits<StopAhead>());

/// The bytes of a value that cross.
template <typename T>
[[nodiscard]] std::size_t told_bytes(const T& value) {
  if constexpr (requires { value.told_bytes(); }) {
    return value.told_bytes();
  } else {
    return sizeof(T);
  }
}

/// False: see send_bytes().
template <typename T>
bool send_sample(int socket, SampleKind kind, const T& value) {
  return send_bytes(socket, bytes_of(kind), bytes_of(value).first(told_bytes(value)));
}

/// Takes the message that look_at_next() found, which is of that kind. False: its size is another
/// one than it says itself. What is behind the bytes that crossed stays in `value` as it was.
template <typename T>
[[nodiscard]] bool take_sample(int socket, std::size_t bytes, T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  SampleKind kind{};
  static_cast<void>(take_bytes(socket, std::as_writable_bytes(std::span(&kind, 1)),
                               std::as_writable_bytes(std::span(&value, 1))));
  return bytes == sizeof kind + told_bytes(value);
}

}  // namespace haptic::server
