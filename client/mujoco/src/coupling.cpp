#include "coupling.hpp"

#include <cmath>

namespace haptic::mujoco {

void Coupling::pull(const std::vector<double>& seen) {
  for (int i = 0; i < model_->nv; ++i) {
    if (tool_->pulls_dof(i)) data_->qfrc_applied[i] = 0.0;
  }
  for (const Place& place : tool_->places()) {
    for (const int dof : place.dofs) {
      data_->qfrc_applied[dof] += data_->qfrc_bias[dof] - data_->qfrc_passive[dof];
    }
    if (place.binding.kind == Binding::Kind::kJoint) {
      pull_joint(place, seen);
    } else {
      pull_frame(place);
    }
  }
  tool_->coupled().take_off(*data_, tool_->owned(), data_->qfrc_applied);
  for (const Follower& follower : tool_->coupled().followers()) pull_follower(follower);
}

void Coupling::pull_joint(const Place& place, const std::vector<double>& seen) {
  const std::size_t i = place.binding.first_coordinate;
  const int dof = place.dofs[0];
  const double scale = place.binding.scale, spring = stiffness(i);
  const double faster = aim_->rate(i) - data_->qvel[dof] / scale;
  pulled_[i] =
      spring * place.apart(seen[i], aim_->at(i)) + 2.0 * std::sqrt(spring * place.mass) * faster;
  data_->qfrc_applied[dof] += pulled_[i] / scale;
}

void Coupling::pull_frame(const Place& place) {
  const std::size_t first = place.binding.first_coordinate;
  const auto nv = static_cast<std::size_t>(model_->nv);
  const Vector3 position = position_of(*data_, place);
  std::vector<mjtNum> jacobian(6 * nv);
  mj_jac(model_, data_, jacobian.data(), jacobian.data() + 3 * nv, position.data(), place.body);
  mjtNum speed[6], force[3], torque[3] = {0.0, 0.0, 0.0};
  mju_mulMatVec(speed, jacobian.data(), data_->qvel, 6, model_->nv);
  for (std::size_t k = 0; k < 3; ++k) {
    const double spring = stiffness(first + k);
    force[k] = spring * (aim_->at(first + k) - position[k]) +
               2.0 * std::sqrt(spring * place.mass) * (aim_->rate(first + k) - speed[k]);
    pulled_[first + k] = force[k];
  }
  if (place.binding.kind == Binding::Kind::kPose) {
    mjtNum here[4], there[4], back[4], error[4], turn[3];
    quaternion_of(*data_, place, here);
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t i = first + 3 + (k + 3) % 4;  // MuJoCo has w first
      there[k] = aim_->at(i);
      back[k] = aim_->at(i) - aim_->rate(i) * model_->opt.timestep;
    }
    mju_normalize4(there);
    mju_normalize4(back);
    mju_negQuat(back, back);
    mju_mulQuat(error, there, back);
    mju_quat2Vel(turn, error, model_->opt.timestep);  // of the aim, in the world
    mju_negQuat(back, here);
    mju_mulQuat(error, there, back);
    // Minus the gradient of c w / 2 times the squared length between the two quaternions.
    const double spring = 0.5 * stiffness(first + 3);
    const double damping = 2.0 * std::sqrt(0.5 * spring * place.inertia);
    for (std::size_t k = 0; k < 3; ++k) {
      torque[k] =
          (error[0] < 0.0 ? -spring : spring) * error[1 + k] + damping * (turn[k] - speed[3 + k]);
    }
  }
  mj_applyFT(model_, data_, force, torque, position.data(), place.body, data_->qfrc_applied);
}

void Coupling::pull_follower(const Follower& one) {
  const double leader = data_->qpos[one.leader_qpos];
  const double apart =
      one.offset + one.ratio * leader - data_->qpos[model_->jnt_qposadr[one.joint]];
  const double faster = one.ratio * data_->qvel[one.leader] - data_->qvel[one.dof];
  const double force = one.stiffness * apart + one.damping * faster;
  data_->qfrc_applied[one.dof] += force;
  data_->qfrc_applied[one.leader] -= one.ratio * force;
}

}  // namespace haptic::mujoco
