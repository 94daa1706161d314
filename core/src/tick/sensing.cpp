#include "sensing.hpp"

#include "haptic/core/safety/limits.hpp"

namespace haptic::core {

Sensing::Sensing(const PipelineConfig& config)
    : layout_(config.kinematics->layout()),
      limits_(config.device),
      needs_force_(config.force_control.enabled()),
      rate_(layout_.n_a()),
      q_(VecQ::Zero(layout_.n_q())) {
  if (config.tracker) tracker_.emplace(*config.tracker, config.device);
}

Sensed Sensing::step(const TickInput& in) noexcept {
  Sensed now;
  if (in.device.health == DeviceHealth::kLost) now.faults.set(Fault::kDeviceLost);
  if (in.device.health == DeviceHealth::kForceOverLimit) now.faults.set(Fault::kForceOverLimit);

  if (tracker_) tracker_->take(in.tracker, in.now, now.tracker);
  if (in.device.fresh) take(in.device.sample, in.now, now);
  if (tracker_ && ready_) tracker_->place(q_);

  now.ready = ready_;
  now.age = ready_ ? in.now - taken_ : Duration::zero();
  now.recent = ready_ && now.age <= kRecentPeriods * limits_.sample_period;
  now.silent = ready_ && now.age > limits_.max_silence;
  if (!now.recent) rate_.forget();
  if (now.silent && limits_.silence_policy == SilencePolicy::kFault) {
    now.faults.set(Fault::kDeviceSilent);
  }
  now.q = q_;
  now.q_a_dot = rate_.value();
  now.tau_measured = tau_measured_;
  return now;
}

void Sensing::take(const DeviceSample& sample, TimePoint now, Sensed& sensed) noexcept {
  VecQ q = sample.q;
  if (tracker_ && q.size() == layout_.n_q()) tracker_->place(q);
  if (q.size() != layout_.n_q() || !q.allFinite() || !fits(sample.tau_measured)) {
    sensed.faults.set(Fault::kSampleNotFinite);
  } else if (!within(q, limits_.q_lower, limits_.q_upper)) {
    sensed.faults.set(Fault::kSampleOutOfRange);
  } else {
    q_ = q;
    tau_measured_ = sample.tau_measured;
    rate_.update(layout_.select(q_), sample.time, kRecentPeriods * limits_.sample_period);
    taken_ = now;
    ready_ = sensed.fresh = true;
  }
}

bool Sensing::fits(const VecA& force) const noexcept {
  if (force.size() == 0) return !needs_force_;
  return force.size() == layout_.n_a() && force.allFinite();
}

}  // namespace haptic::core
