#pragma once
/// Times of the server on the wire's clock, which is the loop's.

#include <cstdint>

#include "haptic/core/time.hpp"
#include "haptic/wire/time.hpp"

namespace haptic::server {

[[nodiscard]] constexpr wire::TimePoint to_wire(core::TimePoint time) noexcept {
  return wire::TimePoint(time.time_since_epoch());
}

/// A reading of a client's steady clock whose difference from the server's does not overflow:
/// (0, 2^62) ns, 146 years.
[[nodiscard]] constexpr bool plausible_reading(std::int64_t ns) noexcept {
  return ns > 0 && ns < (std::int64_t{1} << 62);
}

}  // namespace haptic::server
