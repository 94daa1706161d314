#include "sensing.hpp"

#include <algorithm>
#include <utility>

#include "haptic/core/safety/limits.hpp"

namespace haptic::core {

namespace {

// core/METHOD.md#noise-of-the-sensors:
constexpr double kSlow = 0.15;      ///< 1/s, of a DoF's range
constexpr double kSpeedLag = 0.02;  ///< s, of the speed that opens the low-pass

VecQ per_slow(const Kinematics& kinematics) {
  VecQ per(kinematics.layout().n_q());
  for (Eigen::Index i = 0; i < per.size(); ++i) {
    const DofSpec& dof = kinematics.dofs()[static_cast<std::size_t>(i)];
    per[i] = 1.0 / (kSlow * (dof.upper - dof.lower));
  }
  return per;
}

VecQ longest(const DofLayout& layout, const SensorFilter& filter) {
  VecQ lag = VecQ::Constant(layout.n_q(), seconds(filter.sensed_lag));
  for (int i = 0; i < layout.n_a(); ++i) lag[layout.actuated(i)] = seconds(filter.actuated_lag);
  return lag;
}

}  // namespace

Sensing::Sensing(const PipelineConfig& config)
    : layout_(config.kinematics->layout()),
      limits_(config.device),
      per_slow_(per_slow(*config.kinematics)),
      lag_(longest(layout_, config.filter)),
      ahead_(config.filter.actuated_lag > Duration::zero()),
      needs_force_(config.force_control.enabled()),
      rate_(layout_.n_a(), config.filter.rate_lag),
      q_(VecQ::Zero(layout_.n_q())),
      reading_(q_),
      speed_(q_),
      slope_(q_) {
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
  if (ahead_) now.ahead = layout_.select(VecQ(reading_ - q_));
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
    view.q = reading_[dof];
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
    rate_.update(layout_.select(reading_), sample.time, kRecentPeriods * limits_.sample_period);
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
    slope_.setZero();
    return;
  }
  const double dt_s = seconds(dt), per_s = 1.0 / dt_s, newest = dt_s / (dt_s + kSpeedLag);
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double longest = std::min(lag, lag_[i]);
    if (longest <= 0.0) continue;
    speed_[i] += newest * ((q[i] - before[i]) * per_s - speed_[i]);
    const double share = speed_[i] * per_slow_[i];
    const double k = dt_s / longest * (1.0 + share * share);
    const double way = (dt_s * slope_[i] + k * k * (q[i] - q_[i])) / (1.0 + k + k * k);
    slope_[i] = way * per_s;
    q[i] = q_[i] + way;
  }
}

bool Sensing::fits(const VecA& force) const noexcept {
  if (force.size() == 0) return !needs_force_;
  return force.size() == layout_.n_a() && force.allFinite();
}

}  // namespace haptic::core
