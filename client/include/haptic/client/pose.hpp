#pragma once
/// What a session in the role tracker publishes.

#include <array>
#include <chrono>

namespace haptic::client {

/// Where the tracked body is that carries a device, in the world.
struct Pose {
  std::array<double, 3> position{};                       ///< m
  std::array<double, 4> orientation{0.0, 0.0, 0.0, 1.0};  ///< unit quaternion x, y, z, w
  std::chrono::microseconds valid_for{0};                 ///< 0: the scene's limit alone
};

}  // namespace haptic::client
