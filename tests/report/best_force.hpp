#pragma once
/// The best force of a device with one actuated DoF against known contacts, Eq. (31) for the wish
/// of Eq. (8) (core/METHOD.md#the-best-a-device-can-do).

#include "haptic/core/contacts/plane_projection.hpp"

namespace haptic::report {

/// Depth up to which the best force may push a contact in, rad.
inline constexpr double kContactBand = 0.25 * 0.017453292519943295;

/// W of a finger with J (2 x 2): the torque at its joints of 1 N at its actuator, m/rad.
[[nodiscard]] core::VecX lever(const core::MatXQ& J);

class BestForce {
 public:
  /// `space` must outlive this. `stiffness`: Z_q, N/m. `limit`: of the force, N.
  BestForce(const core::ConfigurationSpace& space, double stiffness, double limit)
      : walls_(space), stiffness_(stiffness), limit_(limit) {}
  /// tau_a (N) at a pose with lever w: Z_q w . dx up to the limit; 0 if it would push the probe
  /// into a wall that it is deeper in than kContactBand. Walls: n . x <= b, unit normals, rad.
  [[nodiscard]] double at(const core::PlaneSet& walls, const core::VecX& x_probe,
                          const core::VecX& w);

 private:
  core::PlaneProjection walls_;
  double stiffness_, limit_;
  core::VecX x_{core::VecX::Zero(2)};
};

}  // namespace haptic::report
