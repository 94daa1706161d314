#pragma once
/// Numbers as refusals and events print them (private to server/session).

#include <cstdio>
#include <string>

#include "haptic/core/time.hpp"

namespace haptic::server {

[[nodiscard]] inline std::string figure(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

[[nodiscard]] inline std::string milliseconds(core::Duration d) {
  return figure(core::seconds(d) * 1e3) + " ms";
}

}  // namespace haptic::server
