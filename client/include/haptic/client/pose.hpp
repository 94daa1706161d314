#pragma once
/// The pose that a session with SessionOptions::tracker publishes.

#include <array>
#include <chrono>

namespace haptic::client {

/// Where the body that carries a device, for example the palm, is in the world.
struct Pose {
  std::array<double, 3> position{};                       ///< m
  std::array<double, 4> orientation{0.0, 0.0, 0.0, 1.0};  ///< unit quaternion x, y, z, w
  std::chrono::microseconds valid_for{
      0};  ///< may count as fresh for this long; 0: as the scene says
};

}  // namespace haptic::client
