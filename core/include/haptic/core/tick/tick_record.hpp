#pragma once
/// Record of one tick: its whole answer, and its input but for the proxy's sample, which is large
/// and has a number. A run is replayed from these and the samples, and the two records of a tick
/// must be the same to the bit.

#include <array>
#include <cstdint>

#include "haptic/core/contacts/plane_projection.hpp"
#include "haptic/core/contacts/proxy_snapshot.hpp"
#include "haptic/core/model/dof_layout.hpp"
#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/passivity/passivity.hpp"
#include "haptic/core/rendering/projection.hpp"
#include "haptic/core/safety/lifecycle.hpp"
#include "haptic/core/tick/tick_input.hpp"

namespace haptic::core {

/// Answer to the Engage request `engage_id` of the command snapshot.
enum class EngageVerdict : std::uint8_t {
  kNone = 0,  ///< no request so far
  kAccepted = 1,
  kNotArmed = 2,        ///< wrong state: ARMED is needed
  kStreamTooYoung = 3,  ///< value: ms without a gap, limit: 200
  kTooFewSamples = 4,   ///< value: samples without a gap, limit: 10
  kStreamStale = 5,     ///< value: age of the newest proxy in ms, limit: hold_end in ms
  kDeviceStale = 6,     ///< value: age of the newest device sample in ms, limit: 3 of its periods
  kOutsideWindow = 7,   ///< value: |Z_q (q*_a - q_a)| of DoF `index`, limit: its engage window
  kReleased = 8,        ///< a Release came in the same tick; which was later is unknown
  kTrackerStale = 9,    ///< value: age of the palm's pose in ms, limit: its hold_end in ms
  kNeverFree = 10,      ///< a held proxy, and no sample of this lease left the probe free
  kTooFast = 11,        ///< value: samples per s that come, limit: per s that were announced
};

struct EngageAnswer {
  std::uint64_t id{0};
  EngageVerdict verdict{EngageVerdict::kNone};
  int index{0};
  double value{0.0};
  double limit{0.0};
};

/// Answer to the clear request `clear_id`: which faults persist because their cause does, or
/// because they came after the request.
struct ClearAnswer {
  std::uint64_t id{0};
  FaultSet refused{};
};

/// The tracked palm's pose in use, if a client says it.
struct TrackerRecord {
  bool on{false};        ///< the scene has a tracker; all else is meaningless without
  int first_dof{0};      ///< of the six in q that are its
  std::uint64_t seq{0};  ///< of the pose in use; 0: none came so far
  Staleness level{Staleness::kLost};
  Duration age{0};       ///< now - born; 0 if there is none
  double ladder{0.0};    ///< upper bound of the gain, by this age
  Duration hold_end{0};  ///< in effect
};

/// The tick itself.
struct Beat {
  std::uint64_t tick{0};
  Duration dt{0};     ///< since the previous tick; the period on the first
  FaultSet faults{};  ///< of the loop, whose cause is present in this tick
};

/// The device as this tick knows it.
struct Sensed {
  /// n_q, newest good sample, low-passed, with the tracker's pose if the scene has one.
  VecQ q{};
  VecA ahead{};         ///< n_a, q_a as read less that of q; size 0: the same
  double lag{0.0};      ///< s, most by which a DoF may be low-passed
  VecA q_a_dot{};       ///< n_a, from device time stamps, low-passed; m/s or rad/s
  VecA tau_measured{};  ///< n_a, with that sample; N or N m; size 0: the device measures none
  TrackerRecord tracker{};
  bool ready{false};    ///< a good sample came, in this tick or before
  bool fresh{false};    ///< in this tick
  bool refused{false};  ///< the newest sample was no good one
  bool recent{false};   ///< the newest one is at most 3 of the device's periods old
  bool silent{false};   ///< it is older than the device's max_silence
  Duration age{0};      ///< since the tick in which it came; 0 before the first
  FaultSet faults{};    ///< of the device, whose cause is present in this tick
};

/// The sample of the proxy in use, which may not be the newest.
struct ProxyInUse {
  ProxyMode mode{ProxyMode::kNone};  ///< kNone: no proxy; the rest keeps its defaults
  std::uint32_t tenure{0};           ///< of the lease that it was sent under
  std::uint64_t seq{0};
  Duration age{0};  ///< now - born
  Staleness level{Staleness::kLost};
  double ladder{0.0};         ///< upper bound of the gain, by this age and the tracker's
  TimePoint gapless_since{};  ///< as in ProxySnapshot
  std::uint64_t gapless_samples{0};
  StreamRate too_fast{};
};

/// Which delay keeps the stiffness below the settings'.
enum class DeratingReason : std::uint8_t {
  kNone = 0,
  kDevice = 1,  ///< of the device's samples
  kHeld = 2,    ///< of a held proxy
  kPlanes = 3,  ///< of planes that are not anchored and change from sample to sample
};

/// The stiffness in effect, if that is not the settings' (core/METHOD.md#stiffness-in-effect).
struct DeratingRecord {
  DeratingReason reason{DeratingReason::kNone};
  Duration delay{0};  ///< measured, mean: age of the samples; of what the proxy was computed from
  VecA stiffness{};   ///< K, n_a; size 0: the settings'
  VecA allowed{};     ///< what it goes towards, n_a
};

/// The proxy at `now`, and the subspace proxy q* that the renderer wants the spring anchored at.
struct Anchor {
  VecX x_probe{};    ///< f(q); in a block (finger) in which f has no value the last one that it had
  VecX x{};          ///< n_x, proxy in use at `now`; size 0 if there is none
  BlockSet free{0};  ///< blocks that pull nothing whatever f is: dx = 0, q* = q
  bool mapped{false};      ///< f has a value at q in every block that the proxy can hold
  bool in_the_way{false};  ///< x is not simply the haptic probe
  PlaneStatus planes{PlaneStatus::kFree};
  std::uint32_t active_planes{0};  ///< bit i: plane i of the sample holds x
  /// Energy that the contacts and the objects behind them store, by the coupling's stiffness, and
  /// that of the coupling itself, ||x (-) x_probe||_W^2 / 2.
  double stored{0.0}, coupling{0.0};
  /// ||.||_W between the sample's x and what its contacts give for the probe it was computed from.
  double unexplained{0.0};
  bool anchored{false};  ///< q_star is of the proxy in use; else nothing pulls
  VecQ q_star{};         ///< n_q, wanted; Effort::q_star is the one in use
  ProjectionStatus projection{ProjectionStatus::kNone};
  double residual{0.0};
  double condition{0.0};
  /// Bound of the error of Z_q S (q_star - q) against the simulation's own proxy, n_a; size 0:
  /// nothing is known of it.
  VecA force_error{};
  LimiterSet limiters{};

  /// S (q* - q), n_a: how far the spring would be stretched, m or rad; 0 if nothing pulls.
  [[nodiscard]] VecA stretch(const DofLayout& layout, const VecQ& q) const noexcept {
    if (!anchored) return VecA::Zero(layout.n_a());
    return layout.select(q_star) - layout.select(q);
  }
};

/// The device's state, the answers to what people and programs asked for, and the gains.
struct Lifecycle {
  LifecycleState state{LifecycleState::kInit};
  bool lost{false};             ///< event LOST: force was given up in this tick, proxy too old
  FaultSet faults{};            ///< latched; a fault of this tick's output is in Effort::faults
  bool arm{false};              ///< the device is asked to be armed
  bool engaged{false};          ///< an Engage took effect in this tick
  EngageAnswer engage{};        ///< to the newest Engage
  std::uint64_t release_id{0};  ///< newest Release acted on
  std::uint64_t stop_id{0};     ///< newest emergency stop acted on
  ClearAnswer clear{};          ///< to the newest ClearFault
  double gain{0.0};             ///< g
  double damping_gain{0.0};     ///< g_d
  LimiterSet limiters{};        ///< NEVER_FREE, OUTSIDE_WINDOW, TOO_FAST
};

/// The force that goes to the device, and the anchor behind it.
struct Effort {
  VecQ q_star{};       ///< n_q, in use: after envelope or guard, and the energy tank
  VecA tau_elastic{};  ///< g Z_q S (q* - q), saturated, guarded, under the envelope
  VecA tau_damping{};  ///< -g_d B q_a_dot, and the passivity controller's part
  VecA tau_a{};        ///< command to the device, n_a; N or N m
  LimiterSet limiters{};
  /// Per actuated DoF, which limits of its own acted in this tick.
  std::array<LimiterSet, kMaxQ> actuator_limiters{};
  VecA temperature_c{};  ///< of the windings, estimated, n_a; nan without a model; size 0: none has
  VecA drive{};          ///< sent instead of tau_a: the force loop's, N or N m, n_a
  VecA position{};       ///< the admittance's, m or rad, n_a; both size 0 if the scene has neither
  /// Bound of |tau_elastic - g times what the simulation's own proxy would give now|, n_a; size 0:
  /// nothing is known of it (core/METHOD.md#error-bound).
  VecA error_bound{};
  PassivityRecord passivity{};  ///< tank and observer; zeros if neither is on
  FaultSet faults{};            ///< OUTPUT_NOT_FINITE; latched from the next tick on
};

/// The sum of what the stages of a tick make, in the order in which they make it.
struct TickRecord {
  TickInput input{};
  Beat beat{};
  std::uint64_t settings_id{0};  ///< settings in effect
  Sensed sensed{};
  ProxyInUse proxy{};
  DeratingRecord derating{};
  Anchor anchor{};
  Lifecycle life{};
  Effort effort{};

  /// Latched, and of this tick's output.
  [[nodiscard]] FaultSet faults() const noexcept { return life.faults | effort.faults; }
  /// Active in this tick.
  [[nodiscard]] LimiterSet limiters() const noexcept {
    LimiterSet all = anchor.limiters | life.limiters | effort.limiters;
    if (derating.reason != DeratingReason::kNone) all.set(Limiter::kDerated);
    return all;
  }
};

}  // namespace haptic::core
