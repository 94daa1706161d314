#pragma once
/// What the server says of a device at one tick. Units are SI. "Per DoF", "per actuated DoF" and
/// "per coordinate" mean one value for each, in the order of DeviceInfo. Fields have the names of
/// proto/haptic/v1/session.proto.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace haptic::client {

/// How a proxy acts between two samples.
enum class Mode : std::uint8_t {
  kNone = 0,    ///< only in states: no proxy is in use
  kHeld = 1,    ///< it stays where it is
  kFree = 2,    ///< nothing is in the way: no force
  kPlanes = 3,  ///< the server keeps the probe out of planes
};
/// Of a sample in use: by its age force is full (FRESH, HOLD), fades (FADE) or is gone (LOST).
/// The delay that lowers the stiffness (core/METHOD.md#stiffness-in-effect).
enum class Derating : std::uint8_t { kNone = 0, kDevice = 1, kHeld = 2, kPlanes = 3 };
enum class Staleness : std::uint8_t { kUnknown = 0, kFresh = 1, kHold = 2, kFade = 3, kLost = 4 };
/// What brought a sample or a state.
enum class Carrier : std::uint8_t { kUnknown = 0, kGrpc = 1, kUdp = 2 };
/// What a device is ready for. Force is rendered from kEngaging to kReleasing only.
enum class Lifecycle : std::uint8_t {
  kUnknown = 0,
  kInit = 1,       ///< the device opens
  kIdle = 2,       ///< no controller has the device
  kArmed = 3,      ///< a controller has it and may ask for force; damping only
  kEngaging = 4,   ///< force rises
  kEngaged = 5,    ///< force is fully on
  kReleasing = 6,  ///< force fades out
  kFault = 7,      ///< zero force until the fault is cleared
  kClosing = 8,    ///< the server ends
};
[[nodiscard]] const char* name(Lifecycle state) noexcept;      ///< "ENGAGED"
[[nodiscard]] const char* name(Staleness staleness) noexcept;  ///< "FRESH"
[[nodiscard]] const char* name(Carrier carrier) noexcept;      ///< "GRPC"
/// The names of the bits of DeviceState::faults and DeviceState::limiters, for example
/// {"LOOP_LATE", "EMERGENCY_STOP"}. A bit that this library does not know is named by its number.
[[nodiscard]] std::vector<std::string> fault_names(std::uint32_t faults);
[[nodiscard]] std::vector<std::string> limiter_names(std::uint32_t limiters);

// Every structure lists its fields in for_each(), which calls f(name, member) with the field's name
// in session.proto. A state is read by these lists.

/// The server's account of energy: core/METHOD.md#energy-tank and
/// core/METHOD.md#passivity-observer.
struct PassivityState {
  double tank{0.0};      ///< J; what changes of the spring may still put in
  double storage{0.0};   ///< J; stored in the spring in use
  double scale{0.0};     ///< of the spring's deviation; below 1 the tank throttles it
  double observed{0.0};  ///< J; taken from the user beyond what is stored
  double alpha{0.0};     ///< s; the passivity controller adds alpha times the stiffness as damping

  template <typename F>
  static void for_each(PassivityState& s, F&& f) {
    f("tank", s.tank);
    f("storage", s.storage);
    f("scale", s.scale);
    f("observed", s.observed);
    f("alpha", s.alpha);
  }

  friend bool operator==(const PassivityState&, const PassivityState&) = default;
};

/// The tracker's pose in use.
struct TrackerState {
  std::uint64_t seq_used{0};         ///< 0: none came so far
  std::chrono::microseconds age{0};  ///< meaningless while seq_used is 0
  Staleness staleness{Staleness::kUnknown};

  template <typename F>
  static void for_each(TrackerState& s, F&& f) {
    f("seq_used", s.seq_used);
    f("age_us", s.age);
    f("staleness", s.staleness);
  }

  friend bool operator==(const TrackerState&, const TrackerState&) = default;
};

/// How far the force of the linearised subspace method, Eq. (8), is from pushing along with a
/// motion of the device, with the proxy held where it is: core/METHOD.md#exact-derivatives.
struct CertificateState {
  enum class Status : std::uint8_t {
    kUnknown = 0,
    kComputed = 1,
    kIdle = 2,           ///< no proxy that is displaced: nothing pulls
    kOtherRenderer = 3,  ///< another renderer than Renderer::kSubspaceLinear is in use
    kMapFailed = 4,      ///< the device's map has no value or no second derivative here
    kNotFullRank = 5,    ///< of the Jacobian of `block`
    kNoStiffness = 6,    ///< an actuator of `block` has stiffness 0
  };
  Status status{Status::kUnknown};
  double margin{0.0};  ///< while kComputed; 1 with the proxy at the probe, 0 or less: not passive
  unsigned block{0};   ///< independent part of the map (a finger) with the least margin

  template <typename F>
  static void for_each(CertificateState& s, F&& f) {
    f("status", s.status);
    f("margin", s.margin);
    f("block", s.block);
  }

  friend bool operator==(const CertificateState&, const CertificateState&) = default;
};
[[nodiscard]] const char* name(CertificateState::Status status) noexcept;  ///< "COMPUTED"

/// A metric W on the next `coordinates` virtual coordinates, for a client that projects its proxy
/// itself: stiff along what the actuators can push, soft along what is only sensed
/// (core/METHOD.md#anisotropic-coupling). In J per product of the units of two coordinates.
struct CouplingBlock {
  unsigned coordinates{0};
  /// The lower triangle of W row by row: W00, W10, W11, W20 ...; empty: the Jacobian has no full
  /// column rank here.
  std::vector<double> lower{};

  template <typename F>
  static void for_each(CouplingBlock& s, F&& f) {
    f("coordinates", s.coordinates);
    f("lower", s.lower);
  }

  friend bool operator==(const CouplingBlock&, const CouplingBlock&) = default;
};

/// The device at one tick. A list that does not apply to the device is empty.
struct DeviceState {
  std::uint64_t seq{0};            ///< number of the tick, from 1; 0: no state yet
  std::int64_t server_time_ns{0};  ///< the server's steady clock
  Lifecycle state{Lifecycle::kUnknown};
  Mode mode{Mode::kFree};                  ///< of the sample in use
  std::uint64_t proxy_seq_used{0};         ///< number of the sample in use; 0: none
  std::chrono::microseconds proxy_age{0};  ///< meaningless while proxy_seq_used is 0
  Staleness staleness{Staleness::kUnknown};
  double gain{0.0};                    ///< on the elastic force, 0 to 1
  Carrier carrier{Carrier::kUnknown};  ///< of the sample in use
  std::uint32_t lease_epoch{0};        ///< number of the lease; rises with every new controller
  std::vector<double> q{};             ///< where the device is, m or rad per DoF
  std::vector<double> q_dot{};         ///< per actuated DoF, m/s or rad/s
  std::vector<double> x_probe{};       ///< the haptic probe f(q), per coordinate
  std::vector<double> x{};             ///< the proxy in use, per coordinate
  std::vector<double> q_star{};        ///< the subspace proxy in use, per DoF
  std::vector<double> tau_a{};         ///< the command, N or N m per actuated DoF
  std::vector<double> tau_elastic{};   ///< its elastic part
  /// How far tau_elastic is at most from what the simulation would make felt now, by what its
  /// sample told; empty: nothing is known of it.
  std::vector<double> error_bound{};
  std::vector<double> stiffness_in_effect{};  ///< N/m or N m/rad per actuated DoF
  /// Why that is less than the gain times the settings', and by which delay, as measured.
  Derating derating{Derating::kNone};
  std::chrono::microseconds derating_delay{0};
  std::vector<double> tau_measured{};  ///< if the device measures force; as tau_a
  /// Sent to the device instead of tau_a if the server closes the force loop (N or N m) or moves
  /// the device by admittance (m or rad).
  std::vector<double> drive{};
  std::vector<double> temperature_c{};  ///< of the windings, estimated; nan: no model
  std::vector<double> reading{};  ///< what the sensors said, if that was refused; otherwise it is q
  unsigned projection{0};         ///< of q_star: a ProjectionStatus of session.proto
  double condition{0.0};          ///< of the equilibrated Jacobian; 0: not computed
  std::uint32_t active_planes{0};  ///< bit n: plane n of the newest sample holds x
  double unexplained{0.0};  ///< of the proxy's displacement, by contacts with an id; in ||.||_W
  std::uint32_t faults{0}, limiters{0};            ///< bits; see fault_names(), limiter_names()
  std::vector<std::uint32_t> actuator_limiters{};  ///< per actuated DoF; empty: none acted
  std::optional<PassivityState> passivity{};       ///< if the scene has a tank or an observer
  std::optional<TrackerState> tracker{};           ///< if it has a tracker
  std::optional<CertificateState> certificate{};   ///< if it asks for one
  std::vector<CouplingBlock> coupling_metric{};    ///< in the order of x, if it has one
  /// This machine's steady clock when the state arrived.
  std::chrono::steady_clock::time_point received{};
  /// The serialised haptic.v1.DeviceState that all of this was read from, for state_fields().
  std::string message{};

  template <typename F>
  static void for_each(DeviceState& s, F&& f) {
    f("seq", s.seq);
    f("server_time_ns", s.server_time_ns);
    f("state", s.state);
    f("mode", s.mode);
    f("proxy_seq_used", s.proxy_seq_used);
    f("proxy_age_us", s.proxy_age);
    f("staleness", s.staleness);
    f("gain", s.gain);
    f("transport", s.carrier);
    f("lease_epoch", s.lease_epoch);
    f("q", s.q);
    f("q_dot", s.q_dot);
    f("x_probe", s.x_probe);
    f("x", s.x);
    f("q_star", s.q_star);
    f("tau_a", s.tau_a);
    f("tau_elastic", s.tau_elastic);
    f("error_bound", s.error_bound);
    f("stiffness_in_effect", s.stiffness_in_effect);
    f("derating", s.derating);
    f("derating_delay_us", s.derating_delay);
    f("tau_measured", s.tau_measured);
    f("drive", s.drive);
    f("temperature_c", s.temperature_c);
    f("reading", s.reading);
    f("projection", s.projection);
    f("condition", s.condition);
    f("active_planes", s.active_planes);
    f("unexplained", s.unexplained);
    f("faults", s.faults);
    f("limiters", s.limiters);
    f("actuator_limiters", s.actuator_limiters);
    f("passivity", s.passivity);
    f("tracker", s.tracker);
    f("certificate", s.certificate);
    f("coupling_metric", s.coupling_metric);
  }

  friend bool operator==(const DeviceState&, const DeviceState&) = default;
};

}  // namespace haptic::client
