#include "hw/simulated/intent.hpp"

#include <cmath>

#include "hw/motion/minimum_jerk.hpp"
#include "hw/motion/motion_csv.hpp"

namespace haptic::hw {

Course::Moment Course::moment(double t) const noexcept {
  Moment now{.risen = minimum_jerk(t / kRise)};
  if (!motion_) return now;
  const double length = motion_->last(), round = length + kReturn;
  const double into = t < round ? t : std::fmod(t, round);  // fmod costs more than all the rest
  now.place = motion_->place(into);
  if (into > length) now.way_back = minimum_jerk((into - length) / kReturn);
  return now;
}

double Course::at(const Moment& moment) const noexcept {
  double aim = target_;
  if (motion_) {
    aim = (*motion_)(moment.place);
    if (moment.way_back > 0.0) aim += moment.way_back * ((*motion_)(0.0) - aim);
  }
  return rest_ + moment.risen * (aim - rest_);
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
