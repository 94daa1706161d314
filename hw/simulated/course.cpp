#include "hw/simulated/course.hpp"

#include <cmath>

#include "hw/motion/minimum_jerk.hpp"

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

}  // namespace haptic::hw
