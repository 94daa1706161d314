#pragma once
/// What the links between a server and its sessions are doing, as the server sees it. Field by field as
/// GetLinkStatsResponse in proto/haptic/v1/haptic_service.proto.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "haptic/client/types.hpp"

namespace haptic::client {

/// How often something was not used, for one reason.
struct Rejected {
  std::string reason{};
  std::uint64_t count{0};
};

/// One direction of one transport, since the session opened. Empty: not known.
struct LinkDirection {
  std::uint64_t received{0}, bytes{0};
  std::uint64_t lost{0}, reordered{0}, duplicate{0}, late{0};  ///< UDP's datagrams
  std::vector<Rejected> rejected{};
  std::optional<std::chrono::nanoseconds> longest_gap{}, jitter{};
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
  double drift{0.0};                   ///< the client's runs faster by this share
  std::chrono::nanoseconds bound{0};   ///< of the error of offset
  unsigned steps{0};                   ///< times the clock was stepped
};

struct SessionLink {
  std::string device{}, client_name{};
  bool observer{false};
  std::uint32_t lease_epoch{0};  ///< 0: never had the lease
  bool holds_lease{false};
  Carrier samples_by{Carrier::kUnknown}, states_by{Carrier::kUnknown};
  std::vector<LinkCarrier> carriers{};
  std::optional<LinkClock> clock{};
  std::optional<std::chrono::nanoseconds> age_p50{}, age_p99{};  ///< of the proxy at use
  std::optional<std::chrono::nanoseconds> age_error_bound{};
  std::uint64_t aged_by_clock{0};  ///< samples whose age counts from before their arrival
};

struct LinkReport {
  std::vector<SessionLink> sessions{};
  std::vector<Rejected> unassigned{};  ///< datagrams that no session answers for
};

}  // namespace haptic::client
