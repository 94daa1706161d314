#include "tests/report/valid_region.hpp"
#include "tests/report/chosen_linkage.hpp"

namespace haptic::report {

bool in_valid_region(const core::FingerDimensions& d, const core::FingerPose& pose) {
  return pose.status == core::MapStatus::kOk && pose.c1 > d.slider1_lower &&
         pose.c1 < d.slider1_upper && pose.c2 > d.slider2_lower && pose.c2 < d.slider2_upper &&
         pose.q_o1 > -0.3 && pose.q_o1 < 1.75 && pose.q_o2 > -0.3 && pose.q_o2 < 2.0;
}

core::VecQ random_pose(std::mt19937_64& random) {
  const core::FingerDimensions& d = chosen_linkage();
  std::uniform_real_distribution<double> l(d.l_x_lower, d.l_x_upper), t(d.q_B_lower, d.q_B_upper);
  for (;;) {
    const double l_x = l(random), q_B = t(random);
    if (in_valid_region(d, core::finger_pose(d, l_x, q_B))) {
      return (core::VecQ(2) << l_x, q_B).finished();
    }
  }
}

}  // namespace haptic::report
