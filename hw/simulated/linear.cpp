#include "hw/simulated/linear.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "haptic/core/error.hpp"
#include "hw/device_limits.hpp"

namespace haptic::hw {
namespace {

void size_or_zero(const char* name, Eigen::Index n_q, core::VecQ& values, bool may_be_negative) {
  if (values.size() == 0) values = core::VecQ::Zero(n_q);
  if (values.size() != n_q) {
    throw core::DeviceError(std::string(name) + ": has " + std::to_string(values.size()) +
                            " value(s); must have one per DoF, " + std::to_string(n_q));
  }
  for (Eigen::Index i = 0; i < n_q; ++i) {
    const std::string entry = std::string(name) + "[" + std::to_string(i) + "]";
    if (may_be_negative) {
      require_finite(entry, values[i]);
    } else {
      require_not_negative(entry, values[i]);
    }
  }
}

SimulatedLinearConfig checked(SimulatedLinearConfig c, const core::Kinematics& kinematics) {
  const Eigen::Index n_q = kinematics.layout().n_q();
  size_or_zero("mass", n_q, c.mass, false);
  for (Eigen::Index i = 0; i < n_q; ++i) {
    require_positive("mass[" + std::to_string(i) + "]", c.mass[i]);
  }
  size_or_zero("damping", n_q, c.damping, false);
  size_or_zero("hand_stiffness", n_q, c.hand_stiffness, false);
  size_or_zero("hand_damping", n_q, c.hand_damping, false);
  size_or_zero("target", n_q, c.target, true);
  return c;
}

}  // namespace

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
    : config_(checked(config, *kinematics)), kinematics_(std::move(kinematics)) {
  const Eigen::Index n_q = kinematics_->layout().n_q();
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
  reading.fresh = false;
  if (closed_) {
    reading.armed = false;
    reading.health = core::DeviceHealth::kLost;
    return;
  }
  for (int n = substeps_.advance(now); n > 0; --n) step();
  arming_.on_read();
  reading.armed = arming_.armed();
  reading.health = core::DeviceHealth::kOk;
  if (now <= last_read_) return;
  last_read_ = now;
  reading.fresh = true;
  reading.sample.seq = ++seq_;
  reading.sample.time = now;
  const double ahead = core::seconds(substeps_.rest());
  reading.sample.q.resize(q_.size());
  for (Eigen::Index i = 0; i < q_.size(); ++i) {
    reading.sample.q[i] = std::clamp(q_[i] + ahead * q_dot_[i], lower_[i], upper_[i]);
  }
  reading.sample.tau_measured.resize(0);
}

void SimulatedLinear::write(core::TimePoint, const Command& command) noexcept {
  arming_.on_write(command.arm && !closed_);
  tau_.setZero();
  const core::DofLayout& layout = kinematics_->layout();
  if (!arming_.armed() || command.tau_a.size() != layout.n_a()) return;
  for (int i = 0; i < layout.n_a(); ++i) {
    const double limit = config_.max_effort[i];
    const double tau = command.tau_a[i];
    tau_[layout.actuated(i)] = std::isfinite(tau) ? std::clamp(tau, -limit, limit) : 0.0;
  }
}

void SimulatedLinear::close() noexcept {
  closed_ = true;
  arming_.disarm();
  tau_.setZero();
}

}  // namespace haptic::hw
