#include "actuation.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

namespace {

/// Up to these shares a bound of the error says something: of the largest force, each by its limit,
/// and of the limit itself, which is less than people feel.
constexpr double kMostOfForce = 0.25;
constexpr double kLeastKnown = 0.002;

}  // namespace

Actuation::Actuation(const ProjectionModel& model, const PipelineConfig& config)
    : layout_(model.layout()), spring_(model, config), held_(VecA::Zero(layout_.n_a())) {
  if (!config.ratings.empty()) ratings_.emplace(config.ratings);
  if (config.force_control.enabled()) {
    force_control_.emplace(config.force_control, layout_.n_a());
    beyond_ = VecA::Zero(layout_.n_a());
    const auto& loops = config.force_control.loops;
    for (std::size_t i = 0; i < loops.size(); ++i) {
      const auto a = static_cast<Eigen::Index>(i);
      beyond_[a] = std::max(0.0, loops[i].output_limit - config.scene.force_limit[a]);
    }
  }
}

Effort Actuation::step(const Beat& beat, const Sensed& sensed, const Anchor& wanted,
                       const Lifecycle& life, const Settings& settings,
                       const Displacement& at) noexcept {
  const int n_a = layout_.n_a();
  Effort effort;
  if (ratings_) ratings_->warm(held_, beat.dt);
  allowed_ = allowed(settings);
  spring_.step(beat, sensed, wanted, life, settings, at, allowed_, effort);

  effort.tau_a.setZero(n_a);
  effort.tau_damping.setZero(n_a);
  effort.tau_elastic.setZero(n_a);
  const bool powered = life.arm && life.state != LifecycleState::kIdle;
  for (int i = 0; i < n_a; ++i) {
    if (powered) {
      limit(i, beat, sensed, life, settings, effort);
    } else {
      limiters_[i].zero();
    }
  }
  if (powered && life.gain > 0.0) report_saturation(settings, effort);
  if (!effort.tau_a.allFinite()) no_output(effort);
  spring_.hold(effort);
  if (wanted.force_error.size() > 0) bound_error(sensed, wanted, life, settings, effort);
  if (force_control_) {
    const FaultSet faults = life.faults | effort.faults;
    const bool asked_for = life.gain > 0.0 || life.damping_gain > 0.0;
    narrow(settings, life);
    drive(beat, sensed, powered && asked_for && !faults.has(Fault::kOutputNotFinite), effort);
  }
  if (ratings_) {
    effort.temperature_c = ratings_->temperatures();
    held_ = effort.drive.size() > 0 ? effort.drive : effort.tau_a;
  }
  return effort;
}

/// A warm winding narrows the whole of a coupled spring: its own share cut off would leave a force
/// that is no gradient. Power and rate are left to limit(): they cut only what pushes along with a
/// motion, which takes energy out of it whatever the other actuators do.
VecA Actuation::allowed(const Settings& settings) const noexcept {
  VecA limit = settings.force_limit;
  for (int i = 0; ratings_ && i < layout_.n_a(); ++i) limit[i] = ratings_->force(i, limit[i]);
  return limit;
}

void Actuation::limit(int i, const Beat& beat, const Sensed& sensed, const Lifecycle& life,
                      const Settings& settings, Effort& effort) noexcept {
  LimiterSet& active = effort.actuator_limiters[static_cast<std::size_t>(i)];
  double damping = -life.damping_gain * settings.damping[i] * sensed.q_a_dot[i];
  if (spring_.controller().size() > 0) damping += spring_.controller()[i];
  const ForceRange range =
      ratings_ ? ratings_->moving(i, sensed.q_a_dot[i], allowed_[i]) : ForceRange{};
  const LimitedForce limited =
      limiters_[i].step(life.gain * spring_.elastic()[i], damping, life.gain, allowed_[i],
                        settings.slew_limit[i], beat.dt, active, range);
  if (allowed_[i] < settings.force_limit[i] && active.has(Limiter::kSaturation)) {
    LimiterSet saturation;
    saturation.set(Limiter::kSaturation);
    active.clear(saturation);
    active.set(Limiter::kTemperature);
  }
  effort.limiters = effort.limiters | active;
  effort.tau_a[i] = limited.total;
  effort.tau_damping[i] = limited.damping;
  effort.tau_elastic[i] = limited.total - limited.damping;
}

void Actuation::report_saturation(const Settings& settings, Effort& effort) const noexcept {
  const int i = spring_.saturated();
  if (i < 0) return;
  const bool warm = allowed_[i] < settings.force_limit[i];
  const Limiter by = warm ? Limiter::kTemperature : Limiter::kSaturation;
  effort.actuator_limiters[static_cast<std::size_t>(i)].set(by);
  effort.limiters.set(by);
}

/// It says nothing if it is no small share of the force, or more than any force. What is held back
/// is known, and so is no part of that share.
void Actuation::bound_error(const Sensed& sensed, const Anchor& wanted, const Lifecycle& life,
                            const Settings& settings, Effort& effort) const noexcept {
  const VecA& limit = settings.force_limit;
  const VecA wish = settings.unlimited(wanted.stretch(layout_, sensed.q));
  double share = kLeastKnown;
  for (int i = 0; i < layout_.n_a(); ++i) {
    share = std::max(share, kMostOfForce * std::abs(wish[i]) / limit[i]);
  }
  if ((wanted.force_error.array() > share * limit.array()).any()) return;
  effort.error_bound =
      life.gain * wanted.force_error + (life.gain * wish - effort.tau_elastic).cwiseAbs();
  if ((effort.error_bound.array() > limit.array()).any()) effort.error_bound.resize(0);
}

void Actuation::no_output(Effort& effort) noexcept {
  effort.faults.set(Fault::kOutputNotFinite);
  effort.tau_a.setZero();
  effort.tau_damping.setZero();
  effort.tau_elastic.setZero();
  for (int i = 0; i < layout_.n_a(); ++i) limiters_[i].zero();
}

/// A drive gives its own friction on top of the force, so it keeps what the scene gives it beyond
/// the scene's force limit.
void Actuation::narrow(const Settings& settings, const Lifecycle& life) noexcept {
  drive_limits_.force = settings.force_limit + beyond_;
  drive_limits_.slew = settings.slew_limit;
  drive_limits_.gain = life.gain;
}

/// A device that is not asked for force is not regulated either: the offset of a load cell would
/// wind up the integral, and move it.
void Actuation::drive(const Beat& beat, const Sensed& sensed, bool wanted,
                      Effort& effort) noexcept {
  if (wanted) {
    const bool known = sensed.tau_measured.size() > 0 && sensed.recent;
    force_control_->step(effort.tau_a, known ? sensed.tau_measured : VecA{}, seconds(beat.dt),
                         drive_limits_);
  } else {
    VecA q_a = layout_.select(sensed.q);
    if (sensed.ahead.size() > 0) q_a += sensed.ahead;
    force_control_->rest(q_a);
  }
  effort.drive = force_control_->drive();
  effort.position = force_control_->position();
  const auto report = [&effort](int i, Limiter by) {
    effort.actuator_limiters[static_cast<std::size_t>(i)].set(by);
    effort.limiters.set(by);
  };
  for (int i = 0; ratings_ && i < static_cast<int>(effort.drive.size()); ++i) {
    // The loop's drive heats the winding, not its reference.
    const double most = ratings_->force(i, std::abs(effort.drive[i]));
    if (std::abs(effort.drive[i]) <= most) continue;
    effort.drive[i] = std::copysign(most, effort.drive[i]);
    report(i, Limiter::kTemperature);
  }
  for (int i = 0; i < layout_.n_a(); ++i) {
    if (force_control_->limited(i)) report(i, Limiter::kDriveLimit);
    if (force_control_->slewed(i)) report(i, Limiter::kSlew);
  }
}

}  // namespace haptic::core
