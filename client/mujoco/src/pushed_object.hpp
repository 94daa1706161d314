#pragma once
/// How the object of a contact moves when the tool pushes it.

#include <vector>

#include "bound_tool.hpp"

namespace haptic::mujoco {

/// The object's own law along the contact's normal (proto/README.md, Objects that are pushed).
///
/// A push along the normal moves the object's joints along u = M^-1 J^T / A, J the way of its
/// surface away from the tool by these joints and A = J M^-1 J^T. Along u it is one mass, 1 / A,
/// with the damping u^T D u and the spring u^T K u of its joints; the load is u^T times all forces
/// on it but this contact's and that damping.
struct PushedObject {
  double mass{0.0};              ///< kg; 0: it cannot move
  double damping{0.0};           ///< N s/m
  double ground_stiffness{0.0};  ///< N/m
  double load{0.0};              ///< N; > 0 pushes it away from the tool
  double velocity{0.0};          ///< m/s; > 0: it recedes
};

/// Needs a whole mj_forward or mj_step. `normal`: of the object, outwards, at `position`;
/// `force`: this contact's, N; `rate`: qvel as this step began, nv.
[[nodiscard]] PushedObject pushed_object(const mjModel& model, mjData& data, const BoundTool& tool,
                                         int body, const Vector3& position, const Vector3& normal,
                                         double force, const std::vector<mjtNum>& rate);

}  // namespace haptic::mujoco
