#include "hw/simulated/intent.hpp"

#include <cmath>

#include "hw/motion/minimum_jerk.hpp"
#include "hw/motion/motion_csv.hpp"

namespace haptic::hw {

double Course::at(double t) const noexcept {
  double aim = target_;
  if (motion_) {
    const double length = motion_->last(), round = length + kReturn;
    const double into = t < round ? t : std::fmod(t, round);  // fmod costs more than all the rest
    aim = (*motion_)(into);
    // On the way back; 0 while the recording plays.
    if (into > length) {
      aim += minimum_jerk((into - length) / kReturn) * ((*motion_)(0.0) - (*motion_)(length));
    }
  }
  return rest_ + minimum_jerk(t / kRise) * (aim - rest_);
}

Intent::Intent(const Eigen::Vector2d& rest, const Eigen::Vector2d& target)
    : Intent(Course(rest[0], target[0]), Course(rest[1], target[1])) {}

Intent::Intent(const Eigen::Vector2d& rest, const std::filesystem::path& motion_file)
    : Intent(recorded(rest, motion_file)) {}

Intent Intent::recorded(const Eigen::Vector2d& rest, const std::filesystem::path& motion_file) {
  MotionTable table = read_motion_csv(motion_file, {joint_angle_columns()});
  return {Course(rest[0], Pchip(table.time_s, std::move(table.values[0]))),
          Course(rest[1], Pchip(table.time_s, std::move(table.values[1])))};
}

}  // namespace haptic::hw
