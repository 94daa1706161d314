#include "supervisor.hpp"

#include "engage.hpp"

namespace haptic::core {

namespace {

/// From a damping gain of 1 to 0.
constexpr Duration kDampingFall{std::chrono::milliseconds(80)};

}  // namespace

Lifecycle Supervisor::step(const TickInput& in, const Beat& beat, const Settings& settings,
                           const Sensed& sensed, const ProxyInUse& proxy, const Anchor& anchor,
                           FaultSet output) noexcept {
  const CommandSnapshot& command = in.command;
  life_.faults = life_.faults | output;
  latch(command, sensed.ready, beat.faults | sensed.faults);

  const LifecycleState before = machine_.state();
  const bool released = command.release_id != life_.release_id;
  life_.release_id = command.release_id;
  bool engaged = false;
  was_free_ = (was_free_ && command.tenure == tenure_) ||
              (proxy.tenure == command.tenure && free(proxy, anchor));
  if (command.engage_id != life_.engage.id) {
    life_.engage =
        judge_engage(command.engage_id, {in.now, before, life_.faults.any(), sensed, proxy, anchor,
                                         settings, layout_, sample_period_, was_free_});
    if (released && life_.engage.verdict == EngageVerdict::kAccepted) {
      life_.engage.verdict = EngageVerdict::kReleased;
    }
    engaged = life_.engage.verdict == EngageVerdict::kAccepted;
    outside_ = life_.engage.verdict == EngageVerdict::kOutsideWindow;
  }

  StateEvents events;
  events.fault = life_.faults.any();
  events.closing = command.closing;
  events.lease_held = command.lease_held;
  events.lease_changed = command.tenure != tenure_;
  events.armed = in.device.armed;
  events.ready = sensed.ready;
  events.engage = engaged;
  events.release = released;
  events.lost = proxy.level == Staleness::kLost ||
                (sensed.tracker.on && sensed.tracker.level == Staleness::kLost);
  tenure_ = command.tenure;
  const LifecycleState state = machine_.step(events, gain_.value());

  // A new holder of the lease did not ask for what the one before was granted.
  if (events.lease_changed && state == LifecycleState::kArmed) force_granted_ = false;
  if (engaged) force_granted_ = true;
  const bool given_up = before == LifecycleState::kReleasing && state != before;
  if (!machine_.wants_armed() || state == LifecycleState::kIdle || given_up) force_granted_ = false;
  move_gains(beat, settings, sensed, proxy, anchor);

  life_.state = state;
  life_.lost = machine_.lost_now();
  life_.arm = machine_.wants_armed();
  life_.engaged = engaged && before == LifecycleState::kArmed;
  life_.gain = gain_.value();
  life_.damping_gain = damping_gain_.value();
  life_.limiters = {};
  outside_ = outside_ && state == LifecycleState::kArmed && !released && !events.lease_changed;
  if (outside_) life_.limiters.set(Limiter::kOutsideWindow);
  if (state == LifecycleState::kArmed && never_free(proxy, was_free_)) {
    life_.limiters.set(Limiter::kNeverFree);
  }
  if (proxy.too_fast.comes_hz > 0.0 && proxy.level != Staleness::kFresh) {
    life_.limiters.set(Limiter::kTooFast);
  }
  return life_;
}

void Supervisor::latch(const CommandSnapshot& command, bool ready, FaultSet causes) noexcept {
  if (command.stop_id != life_.stop_id) {
    life_.stop_id = command.stop_id;
    causes.set(Fault::kEmergencyStop);
  }
  // Before it is ready a device has no force; only a person's stop is worth remembering.
  if (ready || causes.has(Fault::kEmergencyStop)) life_.faults = life_.faults | causes;
  if (command.clear_id != life_.clear.id) clear(command, causes);
}

/// A fault is cleared if it is named and its cause is gone; a stop only by a request that has seen
/// the newest one.
void Supervisor::clear(const CommandSnapshot& command, FaultSet causes) noexcept {
  if (command.clear_stop_id != life_.stop_id) causes.set(Fault::kEmergencyStop);
  life_.clear.id = command.clear_id;
  life_.clear.refused = FaultSet(command.clear.bits() & causes.bits());
  life_.faults.clear(FaultSet(command.clear.bits() & ~causes.bits()));
}

void Supervisor::move_gains(const Beat& beat, const Settings& settings, const Sensed& sensed,
                            const ProxyInUse& proxy, const Anchor& anchor) noexcept {
  const LifecycleState state = machine_.state();
  const StalenessLimits& limits = settings.staleness;
  const bool wanted =
      (state == LifecycleState::kEngaging || state == LifecycleState::kEngaged) && !sensed.silent;
  gain_.step(wanted, proxy.ladder, beat.dt, limits.fade_end - limits.hold_end);
  damping_gain_.step(force_granted_ && anchor.in_the_way && sensed.recent, 1.0, beat.dt,
                     kDampingFall);
  if (!force_granted_ && !carries_force(state)) damping_gain_.zero();
  if (state == LifecycleState::kFault || state == LifecycleState::kClosing) gain_.zero();
}

}  // namespace haptic::core
