#include "haptic/core/control/force_control.hpp"

#include <string>

#include "haptic/core/error.hpp"

namespace haptic::core {

namespace {

void require_one_per_dof(std::size_t entries, int n_a, const char* what) {
  if (entries == static_cast<std::size_t>(n_a)) return;
  throw SceneError(std::string("force_control: ") + std::to_string(entries) + " " + what +
                   ": must be one per actuated DoF, " + std::to_string(n_a));
}

DriveBounds bounds(const DriveLimits& limits, Eigen::Index i, double dt) noexcept {
  if (i >= limits.force.size() || i >= limits.slew.size()) return {};
  return {limits.force[i], limits.slew[i] * dt, limits.gain * limits.force[i]};
}

}  // namespace

ForceControl::ForceControl(const ForceControlSettings& settings, int n_a) {
  if (!settings.loops.empty() && !settings.admittances.empty()) {
    throw SceneError("force_control: must be a force loop or an admittance, not both");
  }
  if (settings.admittances.empty()) {
    require_one_per_dof(settings.loops.size(), n_a, "force loops");
    for (const ForceLoopGains& gains : settings.loops) loops_.emplace_back(gains);
    drive_ = VecA::Zero(n_a);
  } else {
    require_one_per_dof(settings.admittances.size(), n_a, "admittances");
    for (const AdmittanceParameters& p : settings.admittances) admittances_.emplace_back(p);
    position_ = VecA::Zero(n_a);
  }
}

void ForceControl::rest(const VecA& q_a) noexcept {
  limited_ = slewed_ = 0;
  for (ForceLoop& loop : loops_) loop.reset();
  drive_.setZero();
  for (std::size_t i = 0; i < admittances_.size(); ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    admittances_[i].reset(q_a[a]);
    position_[a] = admittances_[i].position();
  }
}

void ForceControl::step(const VecA& reference, const VecA& measured, double dt,
                        const DriveLimits& limits) noexcept {
  if (!(dt > 0.0)) return;
  limited_ = slewed_ = 0;
  const bool known = measured.size() == reference.size();
  for (std::size_t i = 0; i < loops_.size(); ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    if (!known) loops_[i].forget();  // the reference alone: what was integrated may be out of date
    drive_[a] =
        loops_[i].step(reference[a], known ? measured[a] : reference[a], dt, bounds(limits, a, dt));
    if (loops_[i].saturated()) limited_ |= std::uint32_t{1} << i;
    if (loops_[i].slewed()) slewed_ |= std::uint32_t{1} << i;
  }
  for (std::size_t i = 0; i < admittances_.size(); ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    // A device moved by position would run away from a force it does not feel: it stays.
    position_[a] = admittances_[i].step(reference[a], known ? measured[a] : reference[a], dt);
    if (admittances_[i].limited()) limited_ |= std::uint32_t{1} << i;
  }
}

}  // namespace haptic::core
