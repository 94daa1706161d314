#include "pushed_object.hpp"

namespace haptic::mujoco {

PushedObject pushed_object(const mjModel& model, mjData& data, const BoundTool& tool, int body,
                           const Vector3& position, const Vector3& normal, double force,
                           const std::vector<mjtNum>& rate) {
  constexpr double kHeaviest = 1e6;  // kg; beyond, it is a wall
  PushedObject object;
  const auto nv = static_cast<std::size_t>(model.nv);
  std::vector<mjtNum> jacobian(3 * nv), away(nv), motion(nv);
  mj_jac(&model, &data, jacobian.data(), nullptr, position.data(), body);
  bool can_move = false;
  for (std::size_t i = 0; i < nv; ++i) {
    if (tool.owns_dof(static_cast<int>(i))) continue;
    for (std::size_t k = 0; k < 3; ++k) away[i] -= normal[k] * jacobian[k * nv + i];
    can_move = can_move || away[i] != 0.0;
  }
  if (!can_move) return object;
  mj_solveM(&model, &data, motion.data(), away.data(), 1);
  const double inverse = mju_dot(away.data(), motion.data(), model.nv);
  if (!(inverse * kHeaviest > 1.0)) return object;
  object.mass = 1.0 / inverse;
  double push = -force;
  for (std::size_t i = 0; i < nv; ++i) {
    const double u = motion[i] * object.mass;
    if (u == 0.0) continue;
    const int joint = model.dof_jntid[i];
    object.damping += model.dof_damping[i] * u * u;
    object.ground_stiffness += model.jnt_stiffness[joint] * u * u;
    object.velocity += away[i] * rate[i];
    push += u * (data.qfrc_smooth[i] + data.qfrc_constraint[i] + model.dof_damping[i] * rate[i]);
  }
  object.load = push;
  return object;
}

}  // namespace haptic::mujoco
