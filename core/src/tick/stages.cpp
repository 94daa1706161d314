#include "stages.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

namespace {

/// A device sample older than this many of its periods is not recent (core/README.md#one-tick).
constexpr int kRecentPeriods = 3;

/// What Engage asks of the stream (proto/README.md#a-session).
constexpr Duration kEngageGapless{std::chrono::milliseconds(200)};
constexpr std::uint64_t kEngageSamples = 10;

double milliseconds_of(Duration d) noexcept {
  return seconds(d) * 1e3;
}

bool carries_force(DeviceState state) noexcept {
  return state == DeviceState::kEngaging || state == DeviceState::kEngaged ||
         state == DeviceState::kReleasing;
}

/// Component by component the tighter of the two; what is not given stays as the scene has it.
void tighten(VecA& value, const VecA& wanted, const VecA& scene) noexcept {
  value = scene;
  if (wanted.size() != scene.size()) return;
  for (Eigen::Index i = 0; i < scene.size(); ++i) {
    if (wanted[i] >= 0.0) value[i] = std::min(wanted[i], scene[i]);
  }
}

}  // namespace

Pipeline::Stages::Stages(PipelineConfig config)
    : config_(std::move(config)),
      kinematics_(*config_.kinematics),
      layout_(kinematics_.layout()),
      model_(kinematics_, config_.projection),
      settings_(config_.scene),
      map_(kinematics_),
      leaves_out_(model_.has_parts() && !model_.prior() && kinematics_.blocks().size() > 1),
      renderer_(config_.scene.renderer, model_),
      guard_(model_, config_.scene.stiffness),
      local_proxy_(kinematics_.space(), config_.projection.metric),
      rate_(layout_.n_a()),
      late_bucket_(config_.late_bucket_full),
      q_(VecQ::Zero(layout_.n_q())),
      dx_(VecX::Zero(kinematics_.space().n_x())),
      dq_a_(VecA::Zero(layout_.n_a())),
      anchor_(VecA::Zero(layout_.n_a())),
      displayed_(VecA::Ones(layout_.n_a())),
      tau_controller_(VecA::Zero(layout_.n_a())) {
  if (!config_.ratings.empty()) {
    ratings_.emplace(config_.ratings);
    held_ = VecA::Zero(layout_.n_a());
  }
  if (config_.force_control.enabled()) {
    force_control_.emplace(config_.force_control, layout_.n_a());
  }
  if (config_.passivity.enabled()) passivity_.emplace(config_.passivity, layout_.n_a());
  if (model_.coupling()) {
    coupled_.emplace();
    coupled_->gain = 1.0;
    coupled_->stiffness = settings_.stiffness;
    coupled_->Z_q = model_.coupling()->matrix(settings_.stiffness);
  }
  if (config_.tracker) tracker_.emplace(*config_.tracker, config_.device);
  if (config_.monotone_envelope && layout_.n_a() == 1) envelope_.emplace(model_);
  if (config_.passivity_certificate) certificate_.emplace(model_);
  projection_.q_star = q_;
}

TickRecord Pipeline::Stages::tick(const TickInput& input) noexcept {
  TickRecord record;
  record.input = input;
  begin(input, record);
  settings(input.settings);
  device(input, record);
  proxy(input, record);
  projection(record);
  requests(input, record);
  state(input, record);
  force(record);
  return record;
}

void Pipeline::Stages::begin(const TickInput& input, TickRecord& record) noexcept {
  record.tick = ++ticks_;
  record.dt = ticks_ == 1 ? input.period : std::max(input.now - last_now_, Duration::zero());
  last_now_ = input.now;

  causes_ = {};
  late_bucket_.tick(input.loop.skipped);
  // Before the first sample the loop may still be warming up, and there is no force to protect.
  if (!ready_) return;
  if (input.loop.lateness > config_.loop_late_fault) causes_.set(Fault::kLoopLate);
  if (late_bucket_.full()) causes_.set(Fault::kLateBucketFull);
}

void Pipeline::Stages::settings(const RenderSettings& wanted) noexcept {
  if (wanted.id == settings_.id) return;
  const RenderSettings& scene = config_.scene;
  settings_.id = wanted.id;
  tighten(settings_.stiffness, wanted.stiffness, scene.stiffness);
  if (coupled_) {
    coupled_->stiffness = settings_.stiffness;
    coupled_->Z_q = model_.coupling()->matrix(settings_.stiffness);
  }
  tighten(settings_.damping, wanted.damping, scene.damping);
  tighten(settings_.force_limit, wanted.force_limit, scene.force_limit);
  tighten(settings_.slew_limit, wanted.slew_limit, scene.slew_limit);
  tighten(settings_.engage_window, wanted.engage_window, scene.engage_window);
  settings_.direction_guard = wanted.direction_guard || scene.direction_guard;
  settings_.staleness = check(wanted.staleness) == nullptr ? wanted.staleness : scene.staleness;
  settings_.staleness.hold_end = std::min(settings_.staleness.hold_end, scene.staleness.hold_end);
  settings_.staleness.fade_end = std::min(settings_.staleness.fade_end, scene.staleness.fade_end);
  // Another renderer is another anchor: never under force.
  const bool offered = !coupled_ || renders_Z_q(wanted.renderer);
  if (offered && wanted.renderer != renderer_.kind() && !carries_force(machine_.state())) {
    renderer_.change(wanted.renderer);
    project_anew_ = true;
  }
  settings_.renderer = renderer_.kind();
}

bool Pipeline::Stages::device_sample_is_recent(TimePoint now) const noexcept {
  return ready_ && now - last_sample_now_ <= kRecentPeriods * config_.device.sample_period;
}

bool Pipeline::Stages::silent_too_long(TimePoint now) const noexcept {
  return ready_ && now - last_sample_now_ > config_.device.max_silence;
}

bool Pipeline::Stages::force_fits(const VecA& force) const noexcept {
  if (force.size() == 0) return !force_control_;
  return force.size() == layout_.n_a() && all_finite(force);
}

const VecQ& Pipeline::Stages::sensed(const VecQ& q) noexcept {
  if (!tracker_ || q.size() != layout_.n_q()) return q;
  tracked_ = q;
  tracker_->place(tracked_);
  return tracked_;
}

void Pipeline::Stages::device(const TickInput& input, TickRecord& record) noexcept {
  const DeviceReading& reading = input.device;
  const DeviceLimits& limits = config_.device;
  if (reading.health == DeviceHealth::kLost) causes_.set(Fault::kDeviceLost);
  if (reading.health == DeviceHealth::kForceOverLimit) causes_.set(Fault::kForceOverLimit);

  fresh_ = false;
  if (tracker_) tracker_->take(input.tracker, input.now, record.tracker);
  if (reading.fresh) {
    const VecQ& q = sensed(reading.sample.q);
    const VecA& force = reading.sample.tau_measured;
    if (q.size() != layout_.n_q() || !all_finite(q) || !force_fits(force)) {
      causes_.set(Fault::kSampleNotFinite);
    } else if (!within(q, limits.q_lower, limits.q_upper)) {
      causes_.set(Fault::kSampleOutOfRange);
    } else {
      q_ = q;
      tau_measured_ = force;
      rate_.update(layout_.select(q_), reading.sample.time, kRecentPeriods * limits.sample_period);
      last_sample_now_ = input.now;
      ready_ = fresh_ = true;
    }
  }
  if (tracker_ && ready_) tracker_->place(q_);
  if (!device_sample_is_recent(input.now)) rate_.forget();
  if (silent_too_long(input.now) && limits.silence_policy == SilencePolicy::kFault) {
    causes_.set(Fault::kDeviceSilent);
  }
  record.q = q_;
  record.q_a_dot = rate_.value();
}

void Pipeline::Stages::proxy(const TickInput& input, TickRecord& record) noexcept {
  const CommandSnapshot& command = input.command;
  const ProxySnapshot& sample = input.proxy;
  const bool of_this_lease =
      command.lease_held && sample.mode != ProxyMode::kNone && sample.epoch == command.lease_epoch;
  const bool fits = sample.mode == ProxyMode::kFree || fits_space(sample);
  if (carries_force(machine_.state())) {
    // The force of one lease is never led by the samples of the next: it fades out where it is.
    if (of_this_lease && fits && sample.epoch == local_proxy_.sample().epoch) {
      local_proxy_.accept(sample);
    }
  } else if (of_this_lease && fits) {
    local_proxy_.accept(sample);
  } else {
    local_proxy_.forget();
    has_anchor_ = false;
  }

  has_proxy_ = local_proxy_.mode() != ProxyMode::kNone;
  record.proxy_mode = local_proxy_.mode();
  record.proxy_seq = has_proxy_ ? local_proxy_.sample().seq : 0;
  record.proxy_age = has_proxy_ ? input.now - local_proxy_.sample().born : Duration::zero();
  record.staleness =
      has_proxy_ ? staleness(record.proxy_age, local_proxy_.sample().valid_for, settings_.staleness)
                 : Staleness::kLost;
  ladder_ = has_proxy_ ? ladder(record.proxy_age, settings_.staleness) : 0.0;
  if (tracker_) ladder_ = std::min(ladder_, tracker_->ladder());
}

bool Pipeline::Stages::fits_space(const ProxySnapshot& sample) const noexcept {
  const int n_x = kinematics_.space().n_x();
  if (sample.x.size() != n_x || !all_finite_x(sample.x)) return false;
  if (sample.mode != ProxyMode::kPlanes || sample.planes.size() == 0) return true;
  const PlaneSet& planes = sample.planes;
  return planes.normals.rows() == n_x && planes.normals.cols() == planes.size() &&
         planes.normals.allFinite() && planes.offsets.allFinite();
}

void Pipeline::Stages::requests(const TickInput& input, TickRecord& record) noexcept {
  const CommandSnapshot& command = input.command;
  if (command.stop_id != stop_id_) {
    stop_id_ = command.stop_id;
    causes_.set(Fault::kEmergencyStop);
  }
  // Before it is ready a device has no force; only a person's stop is worth remembering.
  if (ready_ || causes_.has(Fault::kEmergencyStop)) latched_ = latched_ | causes_;

  if (command.clear_id != clear_.id) {
    clear_.id = command.clear_id;
    FaultSet persisting = causes_;
    if (command.clear_stop_id != stop_id_) persisting.set(Fault::kEmergencyStop);
    clear_.refused = FaultSet(command.clear.bits() & persisting.bits());
    latched_.clear(FaultSet(command.clear.bits() & ~persisting.bits()));
  }

  released_ = command.release_id != release_id_;
  release_id_ = command.release_id;

  engage_accepted_ = false;
  if (command.engage_id != engage_.id) {
    engage_ = judge_engage(input, record);
    if (released_ && engage_.verdict == EngageVerdict::kAccepted) {
      engage_.verdict = EngageVerdict::kReleased;
    }
    engage_accepted_ = engage_.verdict == EngageVerdict::kAccepted;
  }
}

EngageAnswer Pipeline::Stages::judge_engage(const TickInput& input,
                                            const TickRecord& record) noexcept {
  EngageAnswer answer;
  answer.id = input.command.engage_id;
  const auto refuse = [&answer](EngageVerdict verdict, double value, double limit, int index = 0) {
    answer.verdict = verdict;
    answer.value = value;
    answer.limit = limit;
    answer.index = index;
    return answer;
  };
  const DeviceState now_in = machine_.state();
  answer.verdict = EngageVerdict::kAccepted;
  if (now_in == DeviceState::kEngaging || now_in == DeviceState::kEngaged) return answer;
  if (now_in != DeviceState::kArmed || latched_.any()) {
    return refuse(EngageVerdict::kNotArmed, static_cast<double>(now_in),
                  static_cast<double>(DeviceState::kArmed));
  }
  const ProxySnapshot& sample = local_proxy_.sample();
  if (!has_proxy_ || record.proxy_age >= settings_.staleness.hold_end) {
    return refuse(EngageVerdict::kStreamStale,
                  has_proxy_ ? milliseconds_of(record.proxy_age) : HUGE_VAL,
                  milliseconds_of(settings_.staleness.hold_end));
  }
  if (sample.gapless_samples < kEngageSamples) {
    return refuse(EngageVerdict::kTooFewSamples, static_cast<double>(sample.gapless_samples),
                  static_cast<double>(kEngageSamples));
  }
  const Duration gapless = input.now - sample.gapless_since;
  if (gapless < kEngageGapless) {
    return refuse(EngageVerdict::kStreamTooYoung, milliseconds_of(gapless),
                  milliseconds_of(kEngageGapless));
  }
  if (!device_sample_is_recent(input.now)) {
    return refuse(EngageVerdict::kDeviceStale, milliseconds_of(input.now - last_sample_now_),
                  milliseconds_of(kRecentPeriods * config_.device.sample_period));
  }
  const TrackerRecord& tracker = record.tracker;
  if (tracker_ && (tracker.seq == 0 || tracker.age >= tracker_->limits().hold_end)) {
    return refuse(EngageVerdict::kTrackerStale,
                  tracker.seq != 0 ? milliseconds_of(tracker.age) : HUGE_VAL,
                  milliseconds_of(tracker_->limits().hold_end));
  }
  const VecA unlimited = coupled_ ? VecA(coupled_->Z_q.lazyProduct(dq_a_))
                                  : VecA(settings_.stiffness.cwiseProduct(dq_a_));
  for (int i = 0; i < layout_.n_a(); ++i) {
    const double jump = std::abs(unlimited[i]);
    if (!(jump <= settings_.engage_window[i])) {
      return refuse(EngageVerdict::kOutsideWindow, jump, settings_.engage_window[i], i);
    }
  }
  return answer;
}

void Pipeline::Stages::state(const TickInput& input, TickRecord& record) noexcept {
  const CommandSnapshot& command = input.command;
  StateEvents events;
  events.fault = latched_.any();
  events.closing = command.closing;
  events.lease_held = command.lease_held;
  events.lease_changed = command.lease_epoch != last_epoch_;
  events.armed = input.device.armed;
  events.ready = ready_;
  events.engage = engage_accepted_;
  events.release = released_;
  events.lost = record.staleness == Staleness::kLost ||
                (tracker_ && record.tracker.level == Staleness::kLost);
  last_epoch_ = command.lease_epoch;

  const DeviceState before = machine_.state();
  record.state = machine_.step(events, gain_.value());
  record.lost = machine_.lost_now();

  // Whoever has the lease now did not ask for what the one before was granted.
  if (events.lease_changed && record.state == DeviceState::kArmed) force_granted_ = false;
  if (engage_accepted_) force_granted_ = true;
  if (engage_accepted_ && before == DeviceState::kArmed && passivity_) passivity_->restart();
  const bool force_given_up = before == DeviceState::kReleasing && record.state != before;
  if (!machine_.wants_armed() || record.state == DeviceState::kIdle || force_given_up) {
    force_granted_ = false;
  }

  const bool device_follows = !silent_too_long(input.now);
  const bool wanted =
      (record.state == DeviceState::kEngaging || record.state == DeviceState::kEngaged) &&
      device_follows;
  record.gain = gain_.step(wanted, ladder_, record.dt,
                           settings_.staleness.fade_end - settings_.staleness.hold_end);
  record.damping_gain = damping_gain_.step(
      force_granted_ && local_proxy_.constrained() && device_sample_is_recent(input.now),
      record.dt);
  if (!force_granted_ && !carries_force(record.state)) damping_gain_.zero();
  if (record.state == DeviceState::kFault || record.state == DeviceState::kClosing) gain_.zero();
  record.gain = gain_.value();
  record.damping_gain = damping_gain_.value();

  record.faults = latched_;
  record.arm = machine_.wants_armed();
  record.engage = engage_;
  record.clear = clear_;
  record.release_id = release_id_;
  record.stop_id = stop_id_;
  record.settings_id = settings_.id;
}

}  // namespace haptic::core
