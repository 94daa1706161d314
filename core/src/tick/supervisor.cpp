#include "supervisor.hpp"

#include "engage.hpp"

namespace haptic::core {

Lifecycle Supervisor::step(const TickInput& in, const Beat& beat, const Settings& settings,
                           const Sensed& sensed, const ProxyInUse& proxy, const Anchor& anchor,
                           FaultSet output) noexcept {
  const CommandSnapshot& command = in.command;
  latched_ = latched_ | output;
  latch(command, sensed.ready, beat.faults | sensed.faults);

  const LifecycleState before = machine_.state();
  const bool released = command.release_id != release_id_;
  release_id_ = command.release_id;
  bool engaged = false;
  if (command.engage_id != engage_.id) {
    engage_ = judge_engage(command.engage_id, {in.now, before, latched_.any(), sensed, proxy,
                                               anchor, settings, layout_, sample_period_});
    if (released && engage_.verdict == EngageVerdict::kAccepted) {
      engage_.verdict = EngageVerdict::kReleased;
    }
    engaged = engage_.verdict == EngageVerdict::kAccepted;
  }

  StateEvents events;
  events.fault = latched_.any();
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

  Lifecycle now;
  now.state = state;
  now.lost = machine_.lost_now();
  now.faults = latched_;
  now.arm = machine_.wants_armed();
  now.engaged = engaged && before == LifecycleState::kArmed;
  now.engage = engage_;
  now.release_id = release_id_;
  now.stop_id = stop_id_;
  now.clear = clear_;
  now.gain = gain_.value();
  now.damping_gain = damping_gain_.value();
  return now;
}

void Supervisor::latch(const CommandSnapshot& command, bool ready, FaultSet causes) noexcept {
  if (command.stop_id != stop_id_) {
    stop_id_ = command.stop_id;
    causes.set(Fault::kEmergencyStop);
  }
  // Before it is ready a device has no force; only a person's stop is worth remembering.
  if (ready || causes.has(Fault::kEmergencyStop)) latched_ = latched_ | causes;
  if (command.clear_id != clear_.id) clear(command, causes);
}

/// A fault is cleared if it is named and its cause is gone; a stop only by a request that has seen
/// the newest one.
void Supervisor::clear(const CommandSnapshot& command, FaultSet causes) noexcept {
  if (command.clear_stop_id != stop_id_) causes.set(Fault::kEmergencyStop);
  clear_.id = command.clear_id;
  clear_.refused = FaultSet(command.clear.bits() & causes.bits());
  latched_.clear(FaultSet(command.clear.bits() & ~causes.bits()));
}

void Supervisor::move_gains(const Beat& beat, const Settings& settings, const Sensed& sensed,
                            const ProxyInUse& proxy, const Anchor& anchor) noexcept {
  const LifecycleState state = machine_.state();
  const StalenessLimits& limits = settings.staleness;
  const bool wanted =
      (state == LifecycleState::kEngaging || state == LifecycleState::kEngaged) && !sensed.silent;
  gain_.step(wanted, proxy.ladder, beat.dt, limits.fade_end - limits.hold_end);
  damping_gain_.step(force_granted_ && anchor.in_the_way && sensed.recent, beat.dt);
  if (!force_granted_ && !carries_force(state)) damping_gain_.zero();
  if (state == LifecycleState::kFault || state == LifecycleState::kClosing) gain_.zero();
}

}  // namespace haptic::core
