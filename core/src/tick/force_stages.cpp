#include <algorithm>
#include <cmath>

#include "stages.hpp"

namespace haptic::core {

VecA Pipeline::Stages::spring_force() const noexcept {
  return coupled_ ? coupled_->force(dq_a_) : VecA(settings_.stiffness.cwiseProduct(dq_a_));
}

/// A warm winding narrows the whole spring: its own share cut off would leave a force that is no
/// gradient. Power and rate are left to the limiters: they cut only what pushes along with a
/// motion, which takes energy out of it whatever the others do.
void Pipeline::Stages::hold_within_limits() noexcept {
  VecA limit = settings_.force_limit;
  for (int i = 0; ratings_ && i < layout_.n_a(); ++i) limit[i] = ratings_->force(i, limit[i]);
  weakest_ = coupled_->hold_within(limit);
}

void Pipeline::Stages::report_saturation(TickRecord& record) noexcept {
  if (weakest_ < 0 || !(coupled_->length(dq_a_) > coupled_->radius)) return;
  const bool warm = coupled_->limit[weakest_] < settings_.force_limit[weakest_];
  const Limiter by = warm ? Limiter::kTemperature : Limiter::kSaturation;
  record.actuator_limiters[static_cast<std::size_t>(weakest_)].set(by);
  record.limiters.set(by);
}

bool Pipeline::Stages::withheld(TickRecord& record) noexcept {
  if (!has_anchor_ || !map_ok_) return false;
  const Probe probe{q_, map_.x_probe(), map_.J()};
  if (envelope_) {
    const EnvelopeAnswer answer = envelope_->apply(probe, dx_, renderer_.kind(), projection_);
    if (answer != EnvelopeAnswer::kProxy) record.limiters.set(Limiter::kMonotoneEnvelope);
    if (answer == EnvelopeAnswer::kEarlier) {
      dq_a_ = layout_.select(projection_.q_star) - layout_.select(q_);
    }
    if (answer != EnvelopeAnswer::kWithheld) return false;
  } else {
    const bool guarded = settings_.direction_guard || config_.monotone_envelope;
    const VecA elastic = spring_force();
    if (!guarded || guard_.allows(probe, dx_, elastic)) return false;
    record.limiters.set(Limiter::kDirectionGuard);
  }
  dq_a_.setZero();
  for (int i = 0; i < layout_.n_a(); ++i) {
    projection_.q_star[layout_.actuated(i)] = q_[layout_.actuated(i)];
  }
  return true;
}

/// core/METHOD.md#energy-tank's spring, but as stiff as it can be felt: the same force from a
/// stiffer spring with a nearer anchor. Any such choice keeps the book exact; with Z_q itself a
/// baseline that displays three times as much is throttled in a plain press, for energy that the
/// user did put in.
void Pipeline::Stages::displayed() noexcept {
  renderer_.displayed_bound({q_, map_.x_probe(), map_.J()}, dx_, settings_.stiffness, displayed_);
  const VecA& damping = config_.passivity.device_damping;
  const double hold = seconds(config_.device.sample_period);
  for (int i = 0; i < layout_.n_a(); ++i) {
    const double b = damping.size() > 0 ? damping[i] : 0.0;
    const double paid = 2.0 * b / hold;  // core/METHOD.md#sampled-data: b > K T/2
    displayed_[i] = std::clamp(displayed_[i], 1.0, std::max(1.0, paid / settings_.stiffness[i]));
  }
}

void Pipeline::Stages::passivity(TickRecord& record, bool spring_is_off) noexcept {
  const VecA q_a = layout_.select(q_);
  passivity_->measure(q_a, fresh_, device_sample_is_recent(record.input.now), record.dt,
                      tau_measured_);
  SpringStorage spring;
  if (coupled_) {
    spring = *coupled_;  // of the subspace methods only: they display Z_q
  } else {
    if (!spring_is_off && map_ok_) displayed();
    spring.stiffness = settings_.stiffness.cwiseProduct(displayed_);
    spring.limit = settings_.force_limit;
  }
  // A spring that is not there stores nothing over the tick either, however far the device moves.
  spring.gain = spring_is_off ? 0.0 : record.gain;
  anchor_ = spring_is_off ? q_a : layout_.select(projection_.q_star);
  for (int i = 0; i < layout_.n_a(); ++i) {  // a factor of 1 leaves the anchor's bits alone
    if (displayed_[i] != 1.0) anchor_[i] = q_a[i] + (anchor_[i] - q_a[i]) / displayed_[i];
  }
  anchor_ = passivity_->admit(spring, anchor_);
  record.passivity = passivity_->record();
  for (int i = 0; i < layout_.n_a() && !spring_is_off; ++i) {
    double& q_star = projection_.q_star[layout_.actuated(i)];
    if (displayed_[i] == 1.0) {
      q_star = anchor_[i];
    } else if (record.passivity.throttled) {
      q_star = q_a[i] + displayed_[i] * (anchor_[i] - q_a[i]);
    }
    dq_a_[i] = q_star - q_a[i];
  }
  if (record.passivity.throttled) record.limiters.set(Limiter::kEnergyTank);
  // Where nothing is in the way there is no drag, whatever the book says.
  if (has_anchor_ && record.damping_gain > 0.0) {
    tau_controller_ = passivity_->controller();
    if (record.passivity.alpha > 0.0) record.limiters.set(Limiter::kPassivity);
  } else {
    tau_controller_.setZero();
    record.passivity.alpha = 0.0;
  }
}

void Pipeline::Stages::limited_force(int i, double elastic, double damping,
                                     TickRecord& record) noexcept {
  LimiterSet& active = record.actuator_limiters[static_cast<std::size_t>(i)];
  double limit = settings_.force_limit[i];
  ForceRange range;
  bool warm = false;
  if (ratings_) {
    const double allowed = ratings_->force(i, limit);
    warm = allowed < limit;
    limit = allowed;
    range = ratings_->moving(i, record.q_a_dot[i], limit);
  }
  const LimitedForce limited = limiters_[i].step(elastic, damping, record.gain, limit,
                                                 settings_.slew_limit[i], record.dt, active, range);
  if (warm && active.has(Limiter::kSaturation)) {
    LimiterSet saturation;
    saturation.set(Limiter::kSaturation);
    active.clear(saturation);
    active.set(Limiter::kTemperature);
  }
  record.limiters = record.limiters | active;
  record.tau_a[i] = limited.total;
  record.tau_damping[i] = limited.damping;
  record.tau_elastic[i] = limited.total - limited.damping;
}

void Pipeline::Stages::no_output(TickRecord& record) noexcept {
  latched_.set(Fault::kOutputNotFinite);
  record.faults = latched_;
  record.tau_a.setZero();
  record.tau_damping.setZero();
  record.tau_elastic.setZero();
  for (int i = 0; i < layout_.n_a(); ++i) limiters_[i].zero();
}

/// Step 11. A device that was not asked for force is not regulated either: the offset of a load
/// cell would wind up the integral, and move it.
void Pipeline::Stages::drive(TickRecord& record, bool powered) noexcept {
  const bool asked_for = record.gain > 0.0 || record.damping_gain > 0.0;
  if (powered && asked_for && !record.faults.has(Fault::kOutputNotFinite)) {
    const bool known = tau_measured_.size() > 0 && device_sample_is_recent(record.input.now);
    force_control_->step(record.tau_a, known ? tau_measured_ : VecA{}, seconds(record.dt));
  } else {
    force_control_->rest(layout_.select(q_));
  }
  record.drive = force_control_->drive();
  record.position = force_control_->position();
  for (int i = 0; ratings_ && i < static_cast<int>(record.drive.size()); ++i) {
    // What heats the winding is what the loop drives, not its reference.
    const double allowed = ratings_->force(i, std::abs(record.drive[i]));
    if (std::abs(record.drive[i]) <= allowed) continue;
    record.drive[i] = std::copysign(allowed, record.drive[i]);
    record.actuator_limiters[static_cast<std::size_t>(i)].set(Limiter::kTemperature);
    record.limiters.set(Limiter::kTemperature);
  }
  for (int i = 0; i < layout_.n_a(); ++i) {
    if (!force_control_->limited(i)) continue;
    record.actuator_limiters[static_cast<std::size_t>(i)].set(Limiter::kDriveLimit);
    record.limiters.set(Limiter::kDriveLimit);
  }
}

void Pipeline::Stages::force(TickRecord& record) noexcept {
  const int n_a = layout_.n_a();
  if (ratings_) ratings_->warm(held_, record.dt);
  if (coupled_) hold_within_limits();
  const bool taken_off = withheld(record);
  if (passivity_) passivity(record, taken_off || !has_anchor_);
  const VecA elastic = spring_force();
  if (projection_.status == ProjectionStatus::kUnreachable) {
    record.limiters.set(Limiter::kRangeClamp);
  }

  record.tau_a.setZero(n_a);
  record.tau_damping.setZero(n_a);
  record.tau_elastic.setZero(n_a);
  const bool powered = machine_.wants_armed() && record.state != DeviceState::kIdle;
  for (int i = 0; i < n_a; ++i) {
    if (!powered) {
      limiters_[i].zero();
      continue;
    }
    double damping = -record.damping_gain * settings_.damping[i] * record.q_a_dot[i];
    if (passivity_) damping += tau_controller_[i];
    limited_force(i, record.gain * elastic[i], damping, record);
  }
  if (coupled_ && powered && record.gain > 0.0) report_saturation(record);
  if (!all_finite(record.tau_a)) no_output(record);
  if (passivity_) passivity_->hold(record.tau_elastic, record.tau_damping);
  if (force_control_) drive(record, powered);
  if (ratings_) {
    record.temperature_c = ratings_->temperatures();
    held_ = force_control_ && record.drive.size() > 0 ? record.drive : record.tau_a;
  }
  record.q_star = projection_.q_star;
  record.projection = projection_.status;
  record.residual = projection_.residual;
  record.condition = projection_.condition;
}

}  // namespace haptic::core
