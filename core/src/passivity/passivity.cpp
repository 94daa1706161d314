#include "haptic/core/passivity/passivity.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

namespace {

bool bounded_below(const VecA& v, double lowest, bool open) noexcept {
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    if (!std::isfinite(v[i]) || v[i] < lowest || (open && v[i] == lowest)) return false;
  }
  return true;
}

bool not_negative(double value) noexcept {
  return std::isfinite(value) && value >= 0.0;
}

}  // namespace

const char* check(const PassivitySettings& settings, int n_a) noexcept {
  const TankSettings& tank = settings.tank;
  const ObserverSettings& observer = settings.observer;
  const auto none_or = [n_a](const VecA& v) { return v.size() == 0 || v.size() == n_a; };
  if (!none_or(settings.device_damping) || !bounded_below(settings.device_damping, 0.0, false)) {
    return "device_damping must have one value >= 0 per actuated DoF, or none";
  }
  if (!none_or(settings.device_inertia) || !bounded_below(settings.device_inertia, 0.0, true)) {
    return "device_inertia must have one value > 0 per actuated DoF, or none";
  }
  if (tank.enabled) {
    if (!std::isfinite(tank.capacity) || tank.capacity <= 0.0) return "tank.capacity must be > 0";
    if (!not_negative(tank.initial) || tank.initial > tank.capacity) {
      return "tank.initial must be in [0, capacity]";
    }
    if (!not_negative(tank.allowed_power)) return "tank.allowed_power must be >= 0";
  }
  if (observer.enabled) {
    if (!not_negative(observer.allowance)) return "observer.allowance must be >= 0";
    if (!not_negative(observer.forgetting)) return "observer.forgetting must be >= 0";
    if (observer.inertia.size() != n_a || !bounded_below(observer.inertia, 0.0, true)) {
      return "observer.inertia must have one value > 0 per actuated DoF";
    }
    if (!none_or(observer.slowest) || !bounded_below(observer.slowest, 0.0, false)) {
      return "observer.slowest must have one value >= 0 per actuated DoF, or none";
    }
  }
  return nullptr;
}

Passivity::Passivity(const PassivitySettings& settings, int n_a)
    : settings_(settings),
      tank_(settings.tank),
      observer_(settings.observer, n_a),
      q_a_(VecA::Zero(n_a)),
      anchor_(VecA::Zero(n_a)),
      elastic_sum_(VecA::Zero(n_a)),
      damping_sum_(VecA::Zero(n_a)),
      elastic_(VecA::Zero(n_a)),
      damping_(VecA::Zero(n_a)) {
  if (settings_.device_damping.size() == 0) settings_.device_damping = VecA::Zero(n_a);
  spring_.stiffness = spring_.limit = VecA::Zero(n_a);
  motion_.dq = motion_.more = motion_.held = motion_.kick = motion_.drift = motion_.jitter =
      VecA::Zero(n_a);
  record_.on = true;
}

void Passivity::restart() noexcept {
  tank_.restart();
  observer_.restart();
}

void Passivity::measure(const VecA& q_a, bool fresh, bool recent, Duration dt,
                        const VecA& force) noexcept {
  const double elapsed = seconds(dt);
  elastic_sum_ += elapsed * elastic_;
  damping_sum_ += elapsed * damping_;
  since_sample_ += elapsed;
  motion_.tick = elapsed;
  record_.hold = {};
  if (!recent) observer_.release();
  if (fresh) {
    if (known_ && since_sample_ > 0.0) {
      book(q_a, force);
    }
    if (!known_) anchor_ = q_a;
    known_ = true;
    q_a_ = q_a;
    force_ = force;
    elastic_sum_.setZero();
    damping_sum_.setZero();
    since_sample_ = 0.0;
  }
  if (settings_.tank.enabled) tank_.refill(elapsed, record_.hold);
}

/// If samples come slower than ticks, the force of each tick in between counts by its time: exact
/// for a steady motion, and exactly the last tick's force if every tick has a sample. A measured
/// force counts with the mean of both samples, as if it had changed linearly between them.
void Passivity::book(const VecA& q_a, const VecA& force) noexcept {
  const VecA dq = q_a - q_a_;
  motion_.more = dq - motion_.dq;
  motion_.dq = dq;
  motion_.held = elastic_;
  motion_.drift +=
      std::min(1.0, since_sample_ / Motion::kDrift_s) * (dq / since_sample_ - motion_.drift);
  motion_.jitter +=
      std::min(1.0, since_sample_ / Motion::kJitter_s) * (motion_.more.cwiseAbs() - motion_.jitter);
  hold_s_ = since_sample_;
  for (Eigen::Index i = 0; i < settings_.device_inertia.size(); ++i) {
    motion_.kick[i] = 0.5 * since_sample_ * since_sample_ / settings_.device_inertia[i];
  }
  const VecA before = anchor_ - q_a_;
  const VecA after = anchor_ - q_a;
  const VecA law = spring_.force(before);
  HoldAccount& account = record_.hold;
  account.leak = spring_.energy(after) - spring_.energy(before) + law.dot(dq);
  VecA elastic = elastic_sum_ / since_sample_;
  if (force.size() == dq.size() && force_.size() == dq.size()) {
    elastic = 0.5 * (force + force_) - damping_sum_ / since_sample_;
  }
  account.limits = -(elastic - law).dot(dq);
  account.rendered = -(damping_sum_ / since_sample_).dot(dq);
  account.device_damping = dq.dot(settings_.device_damping.cwiseProduct(dq)) / since_sample_;
  if (settings_.observer.enabled) observer_.observe(account, dq, since_sample_, spring_);
}

const VecA& Passivity::admit(const SpringStorage& spring, const VecA& anchor, double contacts,
                             const VecA& slew) noexcept {
  const VecA stretch = anchor_ - q_a_;
  double before = spring_.energy(stretch);
  if (spring_.gain == 0.0 && spring.gain > 0.0) {
    // A spring that begins now is booked as if it had been there one tick earlier, at the device's
    // place of then; what the hold leaked since then is paid by the device's damping, as always.
    before = std::min(spring.energy(stretch), record_.hold.device_damping);
  }
  const VecA wanted = anchor - q_a_;
  record_.scale = 1.0;
  if (settings_.tank.enabled) {
    // A force's part in a motion within a hold is known only with the inertia that it moves.
    const bool lends = settings_.device_inertia.size() > 0;
    motion_.slew = hold_s_ * slew;
    motion_.limit = spring.limit;
    record_.scale = tank_.admit(before, spring, wanted, lends ? &motion_ : nullptr, contacts);
  }
  record_.throttled = record_.scale < 1.0;
  // Not q_a + (anchor - q_a): an anchor that stays has to stay to the bit, or each tick would book
  // a rounding error as a change.
  if (record_.throttled) {
    anchor_ = q_a_ + record_.scale * wanted;
  } else {
    anchor_ = anchor;
  }
  spring_ = spring;
  record_.storage = spring_.energy(VecA(anchor_ - q_a_));
  record_.injected = record_.storage - before;
  if (settings_.tank.enabled) record_.storage += tank_.contacts();
  record_.tank = settings_.tank.enabled ? tank_.level() : 0.0;
  record_.observed = observer_.energy();
  record_.alpha = observer_.alpha();
  return anchor_;
}

void Passivity::hold(const VecA& tau_elastic, const VecA& tau_damping) noexcept {
  elastic_ = tau_elastic;
  damping_ = tau_damping;
}

}  // namespace haptic::core
