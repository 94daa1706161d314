#include "derating.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "probe_history.hpp"

namespace haptic::core {

namespace {

constexpr double kMemory_s = 1.0;  ///< of the means, and of a law that was remote
constexpr double kRamp_s = 0.2;    ///< of the whole stiffness
constexpr double kOften = 1.05;    ///< by which K must be too high before it is lowered
/// A hand damps at least this many times as much as the device itself
/// (core/METHOD.md#stiffness-in-effect).
constexpr double kHand = 2.0;
constexpr Duration kOldest{std::chrono::seconds(1)};

double age(TimePoint now, TimePoint then) noexcept {
  return seconds(std::clamp(now - then, Duration::zero(), kOldest));
}

/// Eigenvalue of C = D^-1 Z_q D^-1 that is largest.
double stiffest(const StiffnessCoupling& coupling) {
  const Eigen::MatrixXd C = coupling.matrix(VecA::Ones(coupling.n_a()));
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(C, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .maxCoeff();
}

}  // namespace

Derating::Derating(const PipelineConfig& config, std::shared_ptr<const StiffnessCoupling> coupling)
    : on_(config.derating && config.passivity.device_damping.size() > 0 &&
          config.passivity.device_damping.minCoeff() > 0.0),
      coupling_(std::move(coupling)),
      half_period_s_(0.5 * seconds(config.device.sample_period)),
      device_damping_(config.passivity.device_damping),
      inertia_(config.passivity.device_inertia),
      filter_(config.filter),
      lag_(config.filter.longest_s()) {
  if (on_ && coupling_) coupled_ = stiffest(*coupling_);
}

void Derating::Mean::add(double measured, double after) noexcept {
  over = value < 0.0 ? 0.0 : std::min(over + after, kMemory_s);
  value += over > after ? (measured - value) * after / over : measured - value;
}

DeratingRecord Derating::step(const TickInput& in, const Beat& beat, const Sensed& sensed,
                              const ProxySnapshot& sample, bool moved,
                              const Settings& settings) noexcept {
  if (!on_) return {};
  if (sample.mode == ProxyMode::kNone) forget();
  const bool set = damping_.size() == 0 || settings.id != settings_id_;
  const bool heard =
      sample.mode != ProxyMode::kNone && (sample.tenure != tenure_ || sample.seq != seq_);
  if (set) take(settings);
  if (heard) listen(in, beat, sensed, sample, moved);
  if (set || heard) allow(settings);
  if (derated_ && !move(settings, beat.dt)) derated_.reset();
  in_effect_ = this->settings(settings).stiffness;
  if (!derated_) return {};
  last_.stiffness = in_effect_;
  return last_;
}

/// No proxy is in use: what was measured is of a client that is gone.
void Derating::forget() noexcept {
  derated_.reset();
  acts_ = false;
  remote_ = DeratingReason::kNone;
  came_late_ = oldest_ = {};
  tenure_ = 0;
}

void Derating::take(const Settings& settings) noexcept {
  settings_id_ = settings.id;
  if (in_effect_.size() == 0) in_effect_ = settings.stiffness;
  damping_ = (1.0 + kHand) * device_damping_ + lagged_damping(settings);
  room_ = (damping_.array() / (coupled_ * settings.stiffness.array())).minCoeff();
  if (!derated_) return;
  const VecA K = derated_->stiffness;
  derated_ = settings;
  derated_->stiffness = K.cwiseMin(settings.stiffness);
}

/// B as far as it damps at the highest frequency at which spring and device can swing, the hand
/// adding nothing to the device's mass: its part that is in phase with the rate.
VecA Derating::lagged_damping(const Settings& settings) const noexcept {
  if (filter_.rate_lag == Duration::zero()) return settings.damping;
  if (inertia_.size() == 0) return VecA::Zero(settings.damping.size());
  const double lag2 = seconds(filter_.rate_lag) * seconds(filter_.rate_lag);
  const auto turn2 = coupled_ * lag2 * settings.stiffness.array() / inertia_.array();
  return settings.damping.array() / (1.0 + turn2);
}

/// A sample that leaves the probe free says nothing of how the next one that does not will be.
void Derating::listen(const TickInput& in, const Beat& beat, const Sensed& sensed,
                      const ProxySnapshot& sample, bool moved) noexcept {
  if (sensed.fresh) device_.add(age(in.now, in.device.sample.time), age(in.now, came_));
  if (sample.tenure != tenure_) {
    came_late_ = oldest_ = {};
    remote_ = DeratingReason::kNone;
  } else {
    oldest_.add(age(in.now, seen_), age(in.now, came_));
  }
  const bool told = sample.seen_at != 0 && sample.seen_at <= beat.tick;
  const TimePoint computed = sample.computed == TimePoint{} ? sample.born : sample.computed;
  seen_ = std::min(computed, sample.born);
  if (told) {
    const auto ticks = static_cast<Duration::rep>(std::min<std::uint64_t>(
        beat.tick - sample.seen_at, static_cast<std::uint64_t>(kOldest / in.period)));
    seen_ = in.now - ticks * in.period;
  }
  came_late_.add(age(in.now, seen_), sample.tenure == tenure_ ? age(in.now, came_) : 0.0);
  tenure_ = sample.tenure;
  seq_ = sample.seq;
  came_ = in.now;

  const bool anchored = sample.anchored_at != 0 && sample.anchored_at <= beat.tick &&
                        beat.tick - sample.anchored_at < ProbeHistory::kTicks;
  if (sample.mode == ProxyMode::kHeld) {
    remote_ = DeratingReason::kHeld;
    remote_at_ = in.now;
  } else if (sample.mode == ProxyMode::kPlanes && !anchored && moved) {
    remote_ = DeratingReason::kPlanes;
    remote_at_ = in.now;
  } else if (sample.planes.size() > 0 && seconds(in.now - remote_at_) > kMemory_s) {
    remote_ = DeratingReason::kNone;
  }
}

double Derating::own() const noexcept {
  return half_period_s_ + std::max(0.0, device_.value);
}

double Derating::late() const noexcept {
  const double late = own();
  if (remote_ == DeratingReason::kNone) return late;
  double came = 0.5 * came_late_.value;
  if (oldest_.value < 0.0) return late + came;
  if (remote_ == DeratingReason::kHeld) {  // x is on its way from one sample to the next
    came += 0.125 * std::max(0.0, oldest_.value - came_late_.value);
  }
  return late + std::min(came, 0.25 * oldest_.value);
}

void Derating::allow(const Settings& settings) noexcept {
  const double late_s = late();
  acts_ = late_s > (acts_ ? room_ : kOften * room_);
  double room = room_ - late_s;
  // While x is held it does not answer, and the low-pass is open once contact is lost: the longer
  // one of both delays counts.
  if (remote_ == DeratingReason::kHeld) room = (acts_ ? late_s : room_) - own();
  lag_ = std::clamp(room, 0.0, filter_.longest_s());
  if (acts_ && !derated_) {
    derated_ = settings;
    derated_->stiffness = settings.stiffness.cwiseMin(in_effect_);
  }
  if (!derated_) return;
  last_.allowed = settings.stiffness;
  if (!acts_) return;
  last_.allowed = last_.allowed.cwiseMin(damping_ / (coupled_ * late_s));
  last_.reason = remote_ == DeratingReason::kNone ? DeratingReason::kDevice : remote_;
  const Mean& old = oldest_.value < 0.0 ? came_late_ : oldest_;
  last_.delay = duration(remote_ == DeratingReason::kNone ? device_.value : old.value);
}

bool Derating::move(const Settings& settings, Duration dt) noexcept {
  VecA& K = derated_->stiffness;
  const VecA step = (seconds(dt) / kRamp_s) * settings.stiffness;
  K = last_.allowed.cwiseMax(K - step).cwiseMin(K + step);
  if (coupling_) derated_->Z_q = coupling_->matrix(K);
  return (K.array() < settings.stiffness.array()).any();
}

}  // namespace haptic::core
