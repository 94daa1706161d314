#pragma once
/// What a client sees of the server, its devices and their states. SI units; arrays in the order of
/// DeviceInfo.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "haptic/client/diagnostics.hpp"

namespace haptic::client {

/// kNone: of a state without a proxy in use; nothing to publish.
enum class Mode : std::uint8_t { kNone = 0, kHeld = 1, kFree = 2, kPlanes = 3 };
enum class Staleness : std::uint8_t { kUnknown = 0, kFresh = 1, kHold = 2, kFade = 3, kLost = 4 };
enum class Carrier : std::uint8_t { kUnknown = 0, kGrpc = 1, kUdp = 2 };
enum class Lifecycle : std::uint8_t {
  kUnknown = 0,
  kInit = 1,
  kIdle = 2,
  kArmed = 3,
  kEngaging = 4,
  kEngaged = 5,
  kReleasing = 6,
  kFault = 7,
  kClosing = 8,
};
enum class Renderer : std::uint8_t {
  kUnchanged = 0,
  kStandard = 1,
  kNullSpace = 2,
  kSubspaceLinear = 3,
  kSubspaceExact = 4,
};
[[nodiscard]] const char* name(Lifecycle state) noexcept;      ///< "ENGAGED"
[[nodiscard]] const char* name(Staleness staleness) noexcept;  ///< "FRESH"
[[nodiscard]] const char* name(Carrier carrier) noexcept;      ///< "GRPC"
/// The bits of DeviceState::faults, and of limiters, by name: {"LOOP_LATE", "EMERGENCY_STOP"}.
[[nodiscard]] std::vector<std::string> fault_names(std::uint32_t faults);
[[nodiscard]] std::vector<std::string> limiter_names(std::uint32_t limiters);

struct DegreeOfFreedom {
  std::string name{}, unit{};  ///< unit "m" or "rad"
  bool actuated{false};
  double lower{0.0}, upper{0.0};
  double max_effort{0.0};  ///< N or N m
};

struct VirtualCoordinate {
  std::string name{}, unit{}, kind{};
};

struct DeviceInfo {
  std::string name{}, kind{}, model{}, serial{};
  bool moves{true};
  std::string calibrated{};  ///< day of the calibration in use; empty: none is
  bool measures_force{false};
  std::vector<DegreeOfFreedom> dofs{};
  std::vector<VirtualCoordinate> coordinates{};
  std::vector<double> stiffness_limit{}, damping_limit{}, force_limit{}, slew_limit{},
      engage_window{};  ///< per actuated DoF
  double loop_rate_hz{0.0};
  Lifecycle state{Lifecycle::kUnknown};
  std::uint32_t faults{0};
  std::string controller{};  ///< who holds the lease; empty: nobody
  Renderer renderer{Renderer::kUnchanged};
  unsigned observers{0};
  bool wants_tracker{false};  ///< a client in the role tracker says where its palm is
  std::string tracker{};      ///< who does; empty: nobody
};

struct ServerInfo {
  std::string version{}, protocol{}, scene{};
  std::string realtime_grade{}, realtime_explanation{};
  std::vector<std::string> insecure{};
  std::uint64_t ticks{0}, skipped_ticks{0}, records_dropped{0};
  double lateness_p50_us{0.0}, lateness_p99_us{0.0}, lateness_max_us{0.0};
  double tick_p50_us{0.0}, tick_p99_us{0.0};
  std::string paced_by{};            ///< the device whose samples begin ticks; empty: the timer
  std::uint64_t paced_by_sample{0};  ///< ticks that they began
  unsigned sessions{0};
  std::chrono::nanoseconds uptime{0};
};

/// The server's book of energy, J (session.proto, PassivityState).
struct PassivityState {
  double tank{0.0}, storage{0.0}, scale{0.0}, observed{0.0};
  double alpha{0.0};  ///< s
};

/// The tracker's pose in use (session.proto, TrackerState).
struct TrackerState {
  std::uint64_t seq_used{0};  ///< 0: none came so far
  std::chrono::microseconds age{0};
  Staleness staleness{Staleness::kUnknown};
};

/// The device at one tick. Field by field as DeviceState in proto/haptic/v1/session.proto.
struct DeviceState {
  std::uint64_t seq{0};
  std::int64_t server_time_ns{0};
  std::vector<double> q{}, q_dot{}, x_probe{}, x{}, q_star{}, tau_a{}, tau_elastic{},
      stiffness_in_effect{}, tau_measured{}, temperature_c{}, drive{}, reading{};
  std::uint64_t proxy_seq_used{0};
  std::chrono::microseconds proxy_age{0};
  Staleness staleness{Staleness::kUnknown};
  double gain{0.0};
  Carrier carrier{Carrier::kUnknown};
  Lifecycle state{Lifecycle::kUnknown};
  std::uint32_t faults{0}, limiters{0};
  std::vector<std::uint32_t> actuator_limiters{};  ///< per actuated DoF; empty: none acted
  unsigned projection{0};
  double condition{0.0};
  std::uint32_t lease_epoch{0};
  Mode mode{Mode::kFree};
  std::uint32_t active_planes{0};                 ///< bit n: plane n of the newest sample holds x
  std::optional<TrackerState> tracker{};          ///< where the scene has a tracker
  std::optional<PassivityState> passivity{};      ///< where the scene has a tank or an observer
  std::optional<CertificateState> certificate{};  ///< where the scene asks for it
  std::vector<CouplingBlock> coupling_metric{};   ///< in the order of x, where the scene has one
  /// This machine's steady clock when the state arrived.
  std::chrono::steady_clock::time_point received{};
};

struct Event {
  unsigned kind{0};  ///< number of Event.Kind in session.proto
  std::string reason{}, message{};
  Lifecycle state{Lifecycle::kUnknown};
  std::int64_t server_time_ns{0};
};

/// What the proxy may not pass: normal . x <= offset, linearised at the sample's position.
struct Plane {
  std::vector<double> normal{};  ///< per virtual coordinate; its length is free
  double offset{0.0};
};

/// One state of the proxy in the simulation.
struct Proxy {
  Mode mode{Mode::kFree};
  std::vector<double> position{};  ///< per virtual coordinate; may be empty when free
  std::uint64_t device_seq_used{0};
  std::chrono::microseconds valid_for{0};  ///< 0: the scene's limit alone
  std::vector<Plane> planes{};             ///< kPlanes: at most 6; none: nothing in the way

  [[nodiscard]] static Proxy held(std::vector<double> x) {
    return {Mode::kHeld, std::move(x), 0, {}, {}};
  }
  /// The server keeps the haptic probe out of `planes` at 1 kHz; `x` is where they are linearised.
  /// planes.hpp derives them from a proxy, where the simulation has none.
  [[nodiscard]] static Proxy behind(std::vector<Plane> planes, std::vector<double> x) {
    return {Mode::kPlanes, std::move(x), 0, {}, std::move(planes)};
  }
  [[nodiscard]] static Proxy free() { return {}; }
};

/// The UDP path of a session, as this end sees it.
struct UdpLink {
  bool in_use{false};                      ///< samples go by it
  std::chrono::nanoseconds round_trip{0};  ///< smoothed; 0: not known yet
  std::uint64_t received{0}, lost{0};      ///< datagrams of the server
};

/// Samples since the session opened, over reconnects. Samples that are neither sent nor conflated
/// waited for the transport, or had none. What goes by both carriers, while the UDP path is in doubt
/// or was given up, is counted by each.
struct PublishStatistics {
  std::uint64_t published{0};  ///< calls of publish()
  std::uint64_t sent{0};       ///< handed to the transport
  std::uint64_t conflated{0};  ///< replaced by a newer one before they could be sent
  std::uint64_t accepted{0}, rejected_old{0}, rejected_invalid{0}, backlog{0};  ///< server's word
  std::string last_rejection{};
};

}  // namespace haptic::client
