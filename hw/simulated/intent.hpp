#pragma once
/// Where the simulated user means to go over time: x_des(t) of
/// core/METHOD.md#forces-at-the-finger, a constant or a recording that repeats.

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <utility>

#include "hw/motion/pchip.hpp"

namespace haptic::hw {

/// One coordinate of it.
class Course {
 public:
  /// Rise from the rest pose to the target, or into the recording:
  /// core/METHOD.md#forces-at-the-finger.
  static constexpr double kRise = 0.8;  // s
  /// Way back from the end of a recording to its beginning.
  static constexpr double kReturn = 0.5;  // s

  Course(double rest, double target) noexcept : rest_(rest), target_(target) {}
  Course(double rest, Pchip motion) : rest_(rest), motion_(std::move(motion)) {}

  /// Meaning of `t` seconds after the simulation began, for all courses that play one recording, or
  /// none.
  struct Moment {
    double risen{0.0};     ///< share of the rise
    Pchip::Place place{};  ///< in the recording
    double way_back{0.0};  ///< share of the way from its end to its beginning
  };
  [[nodiscard]] Moment moment(double t) const noexcept;

  /// `t` seconds after the simulation began; continuous. Allocates nothing.
  [[nodiscard]] double at(double t) const noexcept { return at(moment(t)); }
  [[nodiscard]] double at(const Moment& moment) const noexcept;

 private:
  double rest_;
  double target_{0.0};
  std::optional<Pchip> motion_{};
};

/// The two joints of a finger.
class Intent {
 public:
  static constexpr double kRise = Course::kRise;
  static constexpr double kReturn = Course::kReturn;

  /// Both in rad, (MCP, PIP).
  Intent(const Eigen::Vector2d& rest, const Eigen::Vector2d& target);
  /// Joint angles from `motion_file` (columns time_s,q_o1_mcp_rad,q_o2_pip_rad), PCHIP between the
  /// rows and across gaps, because the user moves on when a tracker loses the hand. Throws
  /// DeviceError.
  Intent(const Eigen::Vector2d& rest, const std::filesystem::path& motion_file);

  /// x_des, rad, `t` seconds after the simulation began; continuous. Allocates nothing.
  [[nodiscard]] Eigen::Vector2d at(double t) const noexcept {
    const Course::Moment now = mcp_.moment(t);
    return {mcp_.at(now), pip_.at(now)};
  }

 private:
  Intent(Course mcp, Course pip) : mcp_(std::move(mcp)), pip_(std::move(pip)) {}
  static Intent recorded(const Eigen::Vector2d& rest, const std::filesystem::path& motion_file);

  Course mcp_;
  Course pip_;
};

}  // namespace haptic::hw
