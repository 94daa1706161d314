#include "hw/simulated/intent.hpp"

#include <cmath>

#include "hw/motion/minimum_jerk.hpp"
#include "hw/motion/motion_csv.hpp"

namespace haptic::hw {

Intent::Intent(const Eigen::Vector2d& rest, const Eigen::Vector2d& target)
    : rest_(rest), target_(target) {}

Intent::Intent(const Eigen::Vector2d& rest, const std::filesystem::path& motion_file)
    : rest_(rest) {
  MotionTable table = read_motion_csv(motion_file, {joint_angle_columns()});
  motion_.emplace(Motion{Pchip(table.time_s, std::move(table.values[0])),
                         Pchip(table.time_s, std::move(table.values[1]))});
}

Eigen::Vector2d Intent::Motion::at(double t) const noexcept {
  const double length = mcp.last();
  const double into = std::fmod(t, length + kReturn);
  const double back = minimum_jerk((into - length) / kReturn);  // 0 while the recording plays
  return {mcp(into) + back * (mcp(0.0) - mcp(length)), pip(into) + back * (pip(0.0) - pip(length))};
}

Eigen::Vector2d Intent::at(double t) const noexcept {
  const Eigen::Vector2d aim = motion_ ? motion_->at(t) : target_;
  return rest_ + minimum_jerk(t / kRise) * (aim - rest_);
}

}  // namespace haptic::hw
