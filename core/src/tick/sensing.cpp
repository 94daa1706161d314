#include "sensing.hpp"

#include <algorithm>
#include <utility>

#include "haptic/core/safety/limits.hpp"

namespace haptic::core {

namespace {

// core/METHOD.md#noise-of-the-sensors:
constexpr double kSlow = 0.15;      ///< 1/s, of a DoF's range
constexpr double kSpeedLag = 0.02;  ///< s, of the speed that opens the low-pass

VecQ slow(const Kinematics& kinematics) {
  VecQ speed(kinematics.layout().n_q());
  for (Eigen::Index i = 0; i < speed.size(); ++i) {
    const DofSpec& dof = kinematics.dofs()[static_cast<std::size_t>(i)];
    speed[i] = kSlow * (dof.upper - dof.lower);
  }
  return speed;
}

}  // namespace

Sensing::Sensing(const PipelineConfig& config)
    : layout_(config.kinematics->layout()),
      limits_(config.device),
      slow_(slow(*config.kinematics)),
      needs_force_(config.force_control.enabled()),
      rate_(layout_.n_a(), config.filter.rate_lag),
      q_(VecQ::Zero(layout_.n_q())),
      speed_(q_) {
  if (config.tracker) tracker_.emplace(*config.tracker, config.device);
  for (CellRatings ratings : config.force_control.cells) {
    const auto i = static_cast<Eigen::Index>(cells_.size());
    if (!ratings.damping && i < limits_.drive_damping.size()) {
      ratings.damping = limits_.drive_damping[i];
    }
    cells_.emplace_back(ratings);
  }
}

Sensed Sensing::step(const TickInput& in, Duration dt, const Driven& driven, double lag) noexcept {
  Sensed now;
  now.lag = lag;
  if (in.device.health == DeviceHealth::kLost) now.faults.set(Fault::kDeviceLost);
  if (in.device.health == DeviceHealth::kForceOverLimit) now.faults.set(Fault::kForceOverLimit);

  if (tracker_) tracker_->take(in.tracker, in.now, now.tracker);
  if (in.device.fresh) take(in.device.sample, in.now, now);
  if (tracker_ && ready_) tracker_->place(q_);

  now.ready = ready_;
  now.refused = refused_;
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
    smooth(q, sample.time, sensed.lag);
    q_ = q;
    tau_measured_ = sample.tau_measured;
    rate_.update(layout_.select(q_), sample.time, kRecentPeriods * limits_.sample_period);
    interval_ = seconds(std::max(sample.time - measured_, limits_.sample_period));
    measured_ = sample.time;
    taken_ = now;
    ready_ = sensed.fresh = true;
  }
  refused_ = !sensed.fresh;
}

/// After a gap, as after no sample at all, it begins at the reading. A jump is a speed that opens
/// the low-pass whole.
void Sensing::smooth(VecQ& q, TimePoint time, double lag) noexcept {
  const VecQ before = std::exchange(reading_, q);
  const Duration dt = time - measured_;
  const bool goes_on =
      ready_ && dt > Duration::zero() && dt <= kRecentPeriods * limits_.sample_period;
  if (!goes_on || lag <= 0.0) {
    speed_.setZero();
    return;
  }
  const double dt_s = seconds(dt);
  for (int k = 0; k < layout_.n_n(); ++k) {
    const int i = layout_.sensed(k);
    speed_[i] = low_passed(speed_[i], (q[i] - before[i]) / dt_s, dt_s, kSpeedLag);
    const double share = speed_[i] / slow_[i];
    q[i] = low_passed(q_[i], q[i], dt_s, lag / (1.0 + share * share));
  }
}

bool Sensing::fits(const VecA& force) const noexcept {
  if (force.size() == 0) return !needs_force_;
  return force.size() == layout_.n_a() && force.allFinite();
}

}  // namespace haptic::core
