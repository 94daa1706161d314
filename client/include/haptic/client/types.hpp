#pragma once
/// The server and its devices as a client sees them, and the samples that it sends. Units are SI.
/// "Per DoF", "per actuated DoF" and "per coordinate" mean one value for each, in the order of
/// DeviceInfo.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "haptic/client/plane.hpp"
#include "haptic/client/state.hpp"

namespace haptic::client {

/// How force is computed from proxy and probe; equations as in core/METHOD.md.
enum class Renderer : std::uint8_t {
  kUnchanged = 0,
  kStandard = 1,        ///< a spring in the virtual space, Eq. (1)
  kNullSpace = 2,       ///< the same without what the unactuated DoFs feel, Eq. (3)-(4)
  kSubspaceLinear = 3,  ///< the subspace proxy, linearised, Eq. (7)-(8)
  kSubspaceExact = 4,   ///< the subspace proxy, Eq. (6)
  kPerContact = 5,      ///< Eq. (8), held back if it would push into a contact
};

struct DegreeOfFreedom {
  std::string name{}, unit{};  ///< unit "m" or "rad"
  bool actuated{false};
  double lower{0.0}, upper{0.0};  ///< its range, m or rad
  double max_effort{0.0};         ///< N or N m
};

struct VirtualCoordinate {
  std::string name{}, unit{};
  std::string kind{};  ///< "linear", "angle" (wraps) or "quaternion" (four in a row)
};

struct DeviceInfo {
  std::string name{}, kind{}, model{}, serial{};
  bool moves{true};          ///< false: a recording, which no force moves
  std::string calibrated{};  ///< day of the calibration in use; empty: none is
  bool measures_force{false};
  std::vector<DegreeOfFreedom> dofs{};
  std::vector<VirtualCoordinate> coordinates{};
  /// The most that Session::update() may set, per actuated DoF; see Settings.
  std::vector<double> stiffness_limit{}, damping_limit{}, force_limit{}, slew_limit{};
  /// Engage is refused while the spring's force would be larger, N or N m per actuated DoF.
  std::vector<double> engage_window{};
  double loop_rate_hz{0.0};
  Lifecycle state{Lifecycle::kUnknown};
  std::uint32_t faults{0};
  std::string controller{};  ///< client_name of the session that has the lease; empty: none
  Renderer renderer{Renderer::kUnchanged};
  unsigned observers{0};
  bool wants_tracker{false};  ///< a session with SessionOptions::tracker has to publish poses
  std::string tracker{};      ///< client_name of that session; empty: none
  /// Safeguards that the scene leaves out: "direction_guard", "energy_tank"; empty: it has both.
  std::vector<std::string> unguarded{};
};

struct ServerInfo {
  std::string version{}, protocol{}, scene{};
  std::string realtime_grade{}, realtime_explanation{};  ///< which real-time rights it was given
  std::vector<std::string> insecure{};  ///< what is not protected, for people; empty: nothing
  std::uint64_t ticks{0}, skipped_ticks{0};
  std::uint64_t records_dropped{0};  ///< ticks that are missing in recording and telemetry
  /// How late ticks began, over the last 10 s.
  double lateness_p50_us{0.0}, lateness_p99_us{0.0}, lateness_max_us{0.0};
  double tick_p50_us{0.0}, tick_p99_us{0.0};  ///< how long their computation took
  std::string paced_by{};            ///< the device whose samples begin ticks; empty: the timer
  std::uint64_t paced_by_sample{0};  ///< number of ticks that began so
  unsigned sessions{0};
  std::chrono::nanoseconds uptime{0};
};

/// Something that happened once.
struct Event {
  unsigned kind{0};       ///< an Event.Kind of session.proto
  std::string reason{};   ///< for programs: "ENGAGED -> ARMED", "EMERGENCY_STOP", ...
  std::string message{};  ///< for people
  Lifecycle state{Lifecycle::kUnknown};
  std::int64_t server_time_ns{0};
};

/// Where the simulation's objects let the probe be; made by held(), behind() or free().
struct Proxy {
  Mode mode{Mode::kFree};
  std::vector<double> position{};    ///< x, per coordinate; may be empty if free
  std::uint64_t device_seq_used{0};  ///< `seq` of the state it was computed from; 0: the last given
  std::chrono::microseconds valid_for{0};  ///< may count as fresh for so long; 0: as the scene says
  std::vector<Plane> planes{};             ///< of kPlanes; none: nothing in the way. The deepest
                                           ///< kMaxPlanes are sent

  /// The proxy stays at `x` until the next sample. A coordinate in which `x` is the x_probe of
  /// `device_seq_used` follows the probe instead, as if free, unless the sample before held it at
  /// the same value. Force begins with a held proxy only after a free one, because it does not say
  /// on which side of an object the probe is.
  [[nodiscard]] static Proxy held(std::vector<double> x) {
    return {Mode::kHeld, std::move(x), 0, {}, {}};
  }
  /// The server keeps the probe out of `planes` at 1 kHz; `x` is where they are linearised. They
  /// say which way is out, so force may begin inside an object. If the simulation has no planes,
  /// ContactEstimator in estimator.hpp makes contacts of its proxies.
  [[nodiscard]] static Proxy behind(std::vector<Plane> planes, std::vector<double> x) {
    return {Mode::kPlanes, std::move(x), 0, {}, std::move(planes)};
  }
  /// Nothing is in the way: no force, and no drag.
  [[nodiscard]] static Proxy free() { return {}; }
};

/// The UDP path of a session, as this end sees it.
struct UdpLink {
  bool in_use{false};                      ///< samples go by it
  std::chrono::nanoseconds round_trip{0};  ///< smoothed; 0: not known yet
  std::uint64_t received{0}, lost{0};      ///< datagrams of the server
};

/// Numbers of samples since the session was first opened. A sample that was neither sent nor
/// conflated still waits, or was dropped because there was no stream. A sample that went both by
/// UDP and by the stream, because the UDP path may have failed, counts twice in `sent`.
struct PublishStatistics {
  std::uint64_t published{0};        ///< by publish(); number of the newest
  std::uint64_t sent{0};             ///< handed to a carrier
  std::uint64_t conflated{0};        ///< replaced by a newer one before they could be sent
  std::uint64_t planes_left_out{0};  ///< of a sample, by keep_deepest() in planes.hpp
  // Counts of the server.
  std::uint64_t accepted{0};
  std::uint64_t rejected_old{0};      ///< came after a newer one, or without the lease
  std::uint64_t rejected_invalid{0};  ///< for last_rejection, the newest reason
  std::uint64_t backlog{0};           ///< accepted, but too fast to count as fresh
  std::string last_rejection{};
};

}  // namespace haptic::client
