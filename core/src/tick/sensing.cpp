#include "sensing.hpp"

#include <algorithm>

#include "haptic/core/safety/limits.hpp"

namespace haptic::core {

Sensing::Sensing(const PipelineConfig& config)
    : layout_(config.kinematics->layout()),
      limits_(config.device),
      needs_force_(config.force_control.enabled()),
      rate_(layout_.n_a()),
      q_(VecQ::Zero(layout_.n_q())) {
  if (config.tracker) tracker_.emplace(*config.tracker, config.device);
  for (CellRatings ratings : config.force_control.cells) {
    const auto i = static_cast<Eigen::Index>(cells_.size());
    if (!ratings.damping && i < limits_.drive_damping.size()) {
      ratings.damping = limits_.drive_damping[i];
    }
    cells_.emplace_back(ratings);
  }
}

Sensed Sensing::step(const TickInput& in, Duration dt, const Driven& driven) noexcept {
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
  if (ready_ && !cells_.empty()) doubt(dt, driven, now);
  return now;
}

void Sensing::doubt(Duration dt, const Driven& driven, Sensed& sensed) noexcept {
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    const int dof = layout_.actuated(static_cast<int>(i));
    const double near = kNearEnd * (limits_.q_upper[dof] - limits_.q_lower[dof]);
    CellView view;
    view.reading = tau_measured_[a];
    view.fresh = sensed.fresh;
    view.interval = interval_;
    view.driven = driven.on && a < driven.command.size();
    view.command = a < driven.command.size() ? driven.command[a] : 0.0;
    view.q = q_[dof];
    view.at_lower = view.q < limits_.q_lower[dof] + near;
    view.at_upper = view.q > limits_.q_upper[dof] - near;
    view.dt = seconds(dt);
    sensed.faults = sensed.faults | cells_[i].step(view);
  }
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
    interval_ = seconds(std::max(sample.time - measured_, limits_.sample_period));
    measured_ = sample.time;
    taken_ = now;
    ready_ = sensed.fresh = true;
  }
}

bool Sensing::fits(const VecA& force) const noexcept {
  if (force.size() == 0) return !needs_force_;
  return force.size() == layout_.n_a() && force.allFinite();
}

}  // namespace haptic::core
