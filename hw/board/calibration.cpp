#include "hw/board/calibration.hpp"

#include <cmath>
#include <sstream>

#include "haptic/core/error.hpp"
#include "hw/device_limits.hpp"

namespace haptic::hw::board {
namespace {

[[noreturn]] void refuse(const Calibration& c, const std::string& why) {
  throw core::DeviceError("calibration " + c.source + ": " + why);
}

void check_dof(const Calibration& c, Eigen::Index i, const core::DofSpec& dof) {
  const auto wrong = [&](const char* what, double value, const std::string& rule) {
    std::ostringstream text;
    text << "DoF '" << dof.name << "': " << what << " = " << value << ": must be " << rule;
    refuse(c, text.str());
  };
  if (!std::isfinite(c.scale[i]) || c.scale[i] == 0.0) wrong("scale", c.scale[i], "finite, not 0");
  if (!std::isfinite(c.offset[i])) wrong("offset", c.offset[i], "finite");
  const double margin = kRangeMargin * (dof.upper - dof.lower);
  std::ostringstream range;
  range << "within the DoF's range and 5 % of it, " << dof.lower - margin << " to "
        << dof.upper + margin;
  if (!(c.lower[i] >= dof.lower - margin)) wrong("lower", c.lower[i], range.str());
  if (!(c.upper[i] <= dof.upper + margin)) wrong("upper", c.upper[i], range.str());
  if (!(c.lower[i] < c.upper[i])) wrong("lower", c.lower[i], "below upper");
}

}  // namespace

void check(const Calibration& c, const core::Kinematics& kinematics, const std::string& serial,
           bool measures_force) {
  if (c.serial != serial) {
    refuse(c, "was made with the device '" + c.serial + "' on " + c.date + ", this one is '" +
                  serial + "'; must be its own (hapticctl calibrate)");
  }
  const Eigen::Index n_q = kinematics.layout().n_q();
  for (const core::VecQ* list : {&c.scale, &c.offset, &c.lower, &c.upper}) {
    if (list->size() == n_q) continue;
    refuse(c, "has " + std::to_string(list->size()) + " DoF(s); must have " + std::to_string(n_q));
  }
  const Eigen::Index n_f = measures_force ? kinematics.layout().n_a() : 0;
  if (c.force_zero.size() != n_f) {
    refuse(c, "has " + std::to_string(c.force_zero.size()) +
                  " zero(s) of force; must have one per measured force, " + std::to_string(n_f));
  }
  for (Eigen::Index i = 0; i < n_q; ++i) {
    check_dof(c, i, kinematics.dofs()[static_cast<std::size_t>(i)]);
  }
  if (!c.force_zero.allFinite()) refuse(c, "force_zero: must be finite");
}

void apply(const Calibration& c, core::DeviceSample& sample) noexcept {
  sample.q = c.scale.cwiseProduct(sample.q) + c.offset;
  if (sample.tau_measured.size() == c.force_zero.size()) sample.tau_measured -= c.force_zero;
}

void apply(const Calibration& c, core::DeviceLimits& limits) noexcept {
  const core::VecQ margin = kRangeMargin * (c.upper - c.lower);
  limits.q_lower = c.lower - margin;
  limits.q_upper = c.upper + margin;
}

core::VecA to_readings(const Calibration& c, const core::DofLayout& layout,
                       const core::VecA& position) noexcept {
  core::VecA readings = position;
  for (int i = 0; i < readings.size(); ++i) {
    const int k = layout.actuated(i);
    readings[i] = (position[i] - c.offset[k]) / c.scale[k];
  }
  return readings;
}

core::VecA to_force_readings(const Calibration& c, const core::VecA& tau_a) noexcept {
  if (c.force_zero.size() != tau_a.size()) return tau_a;  // it measures none
  return tau_a + c.force_zero;
}

}  // namespace haptic::hw::board
