#pragma once
/// Numbers and times as messages, events and summaries print them.

#include <charconv>
#include <cstdio>
#include <string>

#include "haptic/core/time.hpp"

namespace haptic::server {

[[nodiscard]] inline std::string figure(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

[[nodiscard]] constexpr double microseconds(core::Duration d) noexcept {
  return core::seconds(d) * 1e6;
}

/// "80 ms", "180.000001 ms": to the nanosecond, so that what breaks a limit never reads as the
/// limit.
[[nodiscard]] inline std::string milliseconds(core::Duration d) {
  char digits[32];
  const double ms = static_cast<double>(d.count()) / 1e6;
  const auto end = std::to_chars(digits, digits + sizeof digits, ms, std::chars_format::fixed).ptr;
  return std::string(digits, end) + " ms";
}

/// A measured time, "203.418 ms": rounded up to the microsecond, for the same reason.
[[nodiscard]] inline std::string measured_ms(core::Duration d) {
  return milliseconds(std::chrono::ceil<std::chrono::microseconds>(d));
}

}  // namespace haptic::server
