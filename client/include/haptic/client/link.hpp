#pragma once
/// Figures of the links between a server and its sessions, as the server measures them:
/// Connection::links(). An optional figure that is empty is not known.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "haptic/client/types.hpp"

namespace haptic::client {

/// How many messages were not used, for one reason.
struct Rejected {
  std::string reason{};
  std::uint64_t count{0};
};

/// One direction of one carrier, since the session opened.
struct LinkDirection {
  std::uint64_t received{0}, bytes{0};
  std::uint64_t lost{0}, reordered{0}, duplicate{0}, late{0};  ///< datagrams; 0 for the stream
  std::vector<Rejected> rejected{};
  std::optional<std::chrono::nanoseconds> longest_gap{};  ///< between two arrivals
  std::optional<std::chrono::nanoseconds> jitter{};       ///< of the transit time, RFC 3550
};

struct LinkCarrier {
  Carrier carrier{Carrier::kUnknown};
  LinkDirection up{};    ///< client to server
  LinkDirection down{};  ///< server to client; of UDP as the client reports it
  std::optional<std::chrono::nanoseconds> round_trip{};  ///< smoothed
  std::optional<std::chrono::nanoseconds> least_round_trip{};
};

/// The client's steady clock against the server's.
struct LinkClock {
  std::chrono::nanoseconds offset{0};  ///< client's minus server's
  double drift{0.0};                   ///< s/s; above 0 the client's clock runs faster
  std::chrono::nanoseconds bound{0};   ///< largest possible error of offset
  unsigned steps{0};                   ///< times the clock was stepped
};

struct SessionLink {
  std::string device{}, client_name{};
  bool observer{false};
  std::uint32_t lease_epoch{0};  ///< number of its lease; 0: it never had one
  bool holds_lease{false};
  Carrier samples_by{Carrier::kUnknown}, states_by{Carrier::kUnknown};
  std::vector<LinkCarrier> carriers{};
  std::optional<LinkClock> clock{};
  /// Age of the proxy when a tick used it: median and 99th percentile, and their largest error.
  std::optional<std::chrono::nanoseconds> age_p50{}, age_p99{}, age_error_bound{};
  /// Samples that were under way for longer than usual: their age counts from when they were sent.
  std::uint64_t aged_by_clock{0};
};

struct LinkReport {
  std::vector<SessionLink> sessions{};
  std::vector<Rejected> unassigned{};  ///< datagrams that belong to no session
};

}  // namespace haptic::client
