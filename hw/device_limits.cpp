#include "hw/device_limits.hpp"

#include <cmath>
#include <sstream>

#include "haptic/core/error.hpp"

namespace haptic::hw {

core::DeviceLimits device_limits(const core::Kinematics& kinematics, const core::VecA& max_effort) {
  const int n_a = kinematics.layout().n_a();
  if (max_effort.size() != n_a) {
    throw core::DeviceError("max_effort: has " + std::to_string(max_effort.size()) +
                            " value(s); must have one per actuated DoF, " + std::to_string(n_a));
  }
  for (int i = 0; i < n_a; ++i) {
    if (std::isfinite(max_effort[i]) && max_effort[i] > 0.0) continue;
    std::ostringstream text;
    text << "max_effort[" << i << "] = " << max_effort[i] << ": must be finite and > 0";
    throw core::DeviceError(text.str());
  }
  core::DeviceLimits limits;
  const auto& dofs = kinematics.dofs();
  const auto n_q = static_cast<Eigen::Index>(dofs.size());
  limits.q_lower.resize(n_q);
  limits.q_upper.resize(n_q);
  for (Eigen::Index i = 0; i < n_q; ++i) {
    const core::DofSpec& dof = dofs[static_cast<std::size_t>(i)];
    const double margin = kRangeMargin * (dof.upper - dof.lower);
    limits.q_lower[i] = dof.lower - margin;
    limits.q_upper[i] = dof.upper + margin;
  }
  limits.max_effort = max_effort;
  return limits;
}

}  // namespace haptic::hw
