#pragma once
/// The target of the simulated user's finger over time: x_des(t) of
/// core/METHOD.md#forces-at-the-finger, a constant or a recording that repeats.

#include <Eigen/Core>
#include <filesystem>
#include <optional>

#include "hw/motion/pchip.hpp"

namespace haptic::hw {

class Intent {
 public:
  /// Rise from the rest pose to the target, or into the recording:
  /// core/METHOD.md#forces-at-the-finger.
  static constexpr double kRise = 0.8;  // s
  /// Way back from the end of a recording to its beginning.
  static constexpr double kReturn = 0.5;  // s

  /// Both in rad, (MCP, PIP).
  Intent(const Eigen::Vector2d& rest, const Eigen::Vector2d& target);
  /// Joint angles from `motion_file` (columns time_s,q_o1_mcp_rad,q_o2_pip_rad), PCHIP between the
  /// rows and across gaps, because the user moves on when a tracker loses the hand. Throws
  /// DeviceError.
  Intent(const Eigen::Vector2d& rest, const std::filesystem::path& motion_file);

  /// x_des, rad, `t` seconds after the simulation began; continuous. Allocates nothing.
  [[nodiscard]] Eigen::Vector2d at(double t) const noexcept;

 private:
  struct Motion {
    Pchip mcp;
    Pchip pip;
    [[nodiscard]] Eigen::Vector2d at(double t) const noexcept;
  };

  Eigen::Vector2d rest_;
  Eigen::Vector2d target_{Eigen::Vector2d::Zero()};
  std::optional<Motion> motion_{};
};

}  // namespace haptic::hw
