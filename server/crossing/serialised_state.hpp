#pragma once
/// A state on its way from the owner to the clients: the bytes of a v1::DeviceState, which a front
/// passes on as they are, and what decides to whom and when.

#include <array>
#include <cstdint>
#include <span>

#include "haptic/core/time.hpp"

namespace haptic::server {

struct SerialisedState {
  /// Bytes of a v1::DeviceState at most; largest_state() of a device must not be above.
  static constexpr std::size_t kMost = 8192;

  std::uint32_t size{0};    ///< of the message
  std::uint32_t tenure{0};  ///< the lease's number for the loop
  std::uint64_t tick{0};
  core::TimePoint now{};
  core::Duration proxy_age{0};
  bool lease_held{false};
  bool proxy_used{false};                 ///< by this tick: `proxy_age` is that proxy's
  std::array<std::uint8_t, kMost> bytes;  ///< those beyond `size` have no value

  [[nodiscard]] std::span<const std::uint8_t> message() const noexcept {
    return std::span(bytes).first(size < kMost ? size : kMost);
  }
  /// Bytes of the struct in use, told its first word (Stamped).
  [[nodiscard]] static constexpr std::size_t bytes_used(std::uint64_t first) noexcept;
};

constexpr std::size_t SerialisedState::bytes_used(std::uint64_t first) noexcept {
  constexpr std::size_t kHead = sizeof(SerialisedState) - kMost;
  return kHead + static_cast<std::uint32_t>(first);
}

}  // namespace haptic::server
