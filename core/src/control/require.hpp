#pragma once
/// What the control laws ask of their parameters.

#include <cmath>
#include <string>

#include "haptic/core/error.hpp"

namespace haptic::core {

/// Throws SceneError, which gives name, value and rule, unless `holds` and the value is finite.
inline void require(bool holds, const char* name, double value, const char* rule) {
  if (holds && std::isfinite(value)) return;
  throw SceneError(std::string(name) + " = " + std::to_string(value) + ": must be finite and " +
                   rule);
}

}  // namespace haptic::core
