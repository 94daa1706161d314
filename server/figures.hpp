#pragma once
/// Numbers and times as messages, events and summaries print them.

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

[[nodiscard]] inline std::string milliseconds(core::Duration d) {
  return figure(core::seconds(d) * 1e3) + " ms";
}

}  // namespace haptic::server
