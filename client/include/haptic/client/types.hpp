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

#include "haptic/client/facts.hpp"
#include "haptic/client/plane.hpp"
#include "haptic/client/state.hpp"

namespace haptic::client {

[[nodiscard]] const char* name(Lifecycle state) noexcept;      ///< "ENGAGED"
[[nodiscard]] const char* name(Staleness staleness) noexcept;  ///< "FRESH"
[[nodiscard]] const char* name(Carrier carrier) noexcept;      ///< "GRPC"
/// The names of the bits of DeviceState::faults and DeviceState::limiters, for example
/// {"LOOP_LATE", "EMERGENCY_STOP"}. A bit that this library does not know is named by its number.
[[nodiscard]] std::vector<std::string> fault_names(std::uint32_t faults);
[[nodiscard]] std::vector<std::string> limiter_names(std::uint32_t limiters);

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
