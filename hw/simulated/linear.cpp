#include "hw/simulated/linear.hpp"

#include <algorithm>
#include <cmath>

#include "hw/device_limits.hpp"

namespace haptic::hw {
std::unique_ptr<Device> SimulatedLinearConfig::open(
    std::shared_ptr<const core::Kinematics> kinematics, core::Duration) const {
  return std::make_unique<SimulatedLinear>(*this, std::move(kinematics));
}

OwnDynamics SimulatedLinearConfig::own_dynamics(const core::DofLayout& layout) const {
  if (damping.size() != layout.n_q() || mass.size() != layout.n_q()) return {};
  return {layout.select(damping), layout.select(mass)};
}

SimulatedLinear::SimulatedLinear(const SimulatedLinearConfig& config,
                                 std::shared_ptr<const core::Kinematics> kinematics)
    : config_(config), kinematics_(std::move(kinematics)) {
  const Eigen::Index n_q = kinematics_->layout().n_q();
  for (core::VecQ* values :
       {&config_.damping, &config_.hand_stiffness, &config_.hand_damping, &config_.target}) {
    if (values->size() == 0) values->setZero(n_q);
  }
  info_.kind = "simulated";
  info_.model = "masses on the DoFs";
  info_.dofs = kinematics_->dofs();
  info_.limits = device_limits(*kinematics_, config_.max_effort);
  lower_.resize(n_q);
  upper_.resize(n_q);
  for (Eigen::Index i = 0; i < n_q; ++i) {
    lower_[i] = info_.dofs[static_cast<std::size_t>(i)].lower;
    upper_[i] = info_.dofs[static_cast<std::size_t>(i)].upper;
  }
  q_ = config_.target.cwiseMax(lower_).cwiseMin(upper_);
  q_dot_ = core::VecQ::Zero(n_q);
  tau_ = core::VecQ::Zero(n_q);
}

void SimulatedLinear::step() noexcept {
  for (Eigen::Index i = 0; i < q_.size(); ++i) {
    const double K = config_.hand_stiffness[i];
    const double B = config_.hand_damping[i] + config_.damping[i];
    const double m = config_.mass[i];
    const double push = tau_[i] + K * (config_.target[i] - q_[i]);
    q_dot_[i] = (m * q_dot_[i] + Substeps::kStepSeconds * push) /
                (m + Substeps::kStepSeconds * (B + Substeps::kStepSeconds * K));
    const double free = q_[i] + Substeps::kStepSeconds * q_dot_[i];
    q_[i] = std::clamp(free, lower_[i], upper_[i]);
    if (q_[i] != free) q_dot_[i] = 0.0;
  }
}

void SimulatedLinear::read(core::TimePoint now, core::DeviceReading& reading) noexcept {
  if (!book_.begin_read(now, reading)) return;
  for (int n = substeps_.advance(now); n > 0; --n) step();
  const core::VecQ q = q_ + core::seconds(substeps_.rest()) * q_dot_;
  book_.deliver(now, q.cwiseMax(lower_).cwiseMin(upper_), reading);
}

void SimulatedLinear::write(core::TimePoint, const Command& command) noexcept {
  tau_.setZero();
  const core::DofLayout& layout = kinematics_->layout();
  if (!book_.follows(command) || command.tau_a.size() != layout.n_a()) return;
  for (int i = 0; i < layout.n_a(); ++i) {
    const double limit = config_.max_effort[i];
    const double tau = command.tau_a[i];
    tau_[layout.actuated(i)] = std::isfinite(tau) ? std::clamp(tau, -limit, limit) : 0.0;
  }
}

void SimulatedLinear::close() noexcept {
  book_.close();
  tau_.setZero();
}

}  // namespace haptic::hw
