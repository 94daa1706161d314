#pragma once
/// What one tick saw and did: its whole input and its whole answer. A run is replayed from these.

#include <array>
#include <cstdint>

#include "haptic/core/model/block_set.hpp"
#include "haptic/core/passivity/passivity.hpp"
#include "haptic/core/projection/certificate.hpp"
#include "haptic/core/projection/plane_projection.hpp"
#include "haptic/core/projection/projection.hpp"
#include "haptic/core/safety/device_state.hpp"
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
  kReleased = 8,        ///< a Release came in the same tick; nobody knows which was later
  kTrackerStale = 9,    ///< value: age of the palm's pose in ms, limit: its hold_end in ms
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

/// The tracked palm's pose in use, where a client says it.
struct TrackerRecord {
  bool on{false};        ///< the scene has a tracker; all else is meaningless without
  int first_dof{0};      ///< of the six in q that are its
  std::uint64_t seq{0};  ///< of the pose in use; 0: none came so far
  Staleness level{Staleness::kLost};
  Duration age{0};  ///< now - born; 0 where there is none
};

struct TickRecord {
  TickInput input{};
  std::uint64_t tick{0};
  Duration dt{0};  ///< since the previous tick; the period on the first

  DeviceState state{DeviceState::kInit};
  bool lost{false};              ///< event LOST: force was given up in this tick, proxy too old
  FaultSet faults{};             ///< latched
  LimiterSet limiters{};         ///< active in this tick
  bool arm{false};               ///< the device is asked to be armed
  EngageAnswer engage{};         ///< to the newest Engage
  std::uint64_t release_id{0};   ///< newest Release acted on
  std::uint64_t stop_id{0};      ///< newest emergency stop acted on
  ClearAnswer clear{};           ///< to the newest ClearFault
  std::uint64_t settings_id{0};  ///< settings in effect

  ProxyMode proxy_mode{ProxyMode::kNone};  ///< of the sample in use, which may not be the newest
  std::uint64_t proxy_seq{0};              ///< of the sample in use; 0 where there is none
  Staleness staleness{Staleness::kLost};
  Duration proxy_age{0};  ///< now - born; 0 where there is no proxy
  TrackerRecord tracker{};
  double gain{0.0};          ///< g
  double damping_gain{0.0};  ///< g_d

  VecQ q{};        ///< n_q, newest sample (held below max_silence)
  VecA q_a_dot{};  ///< n_a, from device time stamps; m/s or rad/s
  /// The blocks (fingers) that nothing could hold in this tick, so that it did not ask for their f:
  /// nan in x_probe and x until ProbeCompletion has filled them in (tick/probe_completion.hpp); and
  /// a block that was one of them and has had no f since it was asked again. 0 where the map has
  /// fewer than two blocks (a hand of one finger), or a metric or prior ties them together.
  BlockSet unprobed{0};
  VecX x_probe{};  ///< f(q)
  VecX x{};        ///< proxy in use at `now`
  PlaneStatus planes{PlaneStatus::kFree};
  std::uint32_t active_planes{0};  ///< bit i: plane i of the sample holds x
  VecQ q_star{};                   ///< subspace proxy in use
  ProjectionStatus projection{ProjectionStatus::kNone};
  double residual{0.0};
  double condition{0.0};
  Certificate certificate{};  ///< of the linearised method, where the scene asks for it

  VecA tau_elastic{};  ///< g Z_q S (q* - q), saturated, guarded, under the envelope
  VecA tau_damping{};  ///< -g_d B q_a_dot, and the passivity controller's part
  VecA tau_a{};        ///< command to the device, n_a; N or N m

  /// Per actuated DoF, which limits of its own acted in this tick.
  std::array<LimiterSet, kMaxQ> actuator_limiters{};
  VecA temperature_c{};  ///< of the windings, estimated, n_a; nan without a model; size 0: none has
  VecA drive{};     ///< what goes to the device instead of tau_a: the force loop's, N or N m, n_a
  VecA position{};  ///< the admittance's, m or rad, n_a; both size 0 where the scene has neither

  PassivityRecord passivity{};  ///< tank and observer; zeros where neither is on
};

/// Equal to the bit, NaNs included: the test of replay.
[[nodiscard]] bool identical(const TickRecord& a, const TickRecord& b) noexcept;

}  // namespace haptic::core
