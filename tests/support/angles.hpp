#pragma once
/// Angles as a person writes them.

#include <numbers>

namespace haptic {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kDegree = kPi / 180.0;  ///< rad

}  // namespace haptic
