#pragma once
/// Eq. (1): tau_a = J_a^T Z_x dx with Z_x = z_x W, the standard method, which ignores
/// underactuation.

#include "haptic/core/projection/projection.hpp"
#include "haptic/core/projection/projection_model.hpp"

namespace haptic::core {

class Standard {
 public:
  explicit Standard(const ProjectionModel& model);
  void project(const Probe& probe, const VecX& dx, const VecA& stiffness, Projection& out) noexcept;

 private:
  ProjectionModel model_;
  VecA tau_a_{};
  VecX dx_W_{};  ///< W^{1/2} dx
  MatXQ J_W_{};  ///< W^{1/2} J
};

}  // namespace haptic::core
