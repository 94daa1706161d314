#pragma once
/// Bounds of a front's service.

#include "haptic/core/time.hpp"
#include "server/base/steady_now.hpp"
#include "server/front/net/connections.hpp"

namespace haptic::server {

/// How long a connection lives whose far end gives no sign of life (proto/README.md, "Every
/// limit"). Force does not wait for that: liveness is the data
/// (proto/README.md#staleness-and-gain). This only gives its memory back.
struct KeepAlive {
  /// A far end that was silent this long is asked for a sign of life (a PING).
  core::Duration ask_after{std::chrono::seconds(10)};
  /// It has this long to answer. Well above 5 s: at that pace gRPC looks after the connection of a
  /// client without an open call, and what that asks next must not find it closed.
  core::Duration answer_within{std::chrono::seconds(20)};

  [[nodiscard]] constexpr core::Duration given_up_after() const {
    return ask_after + answer_within;
  }
};

/// Bounds of the service beyond those that the scene says.
struct ServiceLimits {
  /// States per second that all streams but the controllers' may cost together, an equal share per
  /// device; what is above is conflated, in turns. Measured on a shared 2-core VM: 16 watchers at 1
  /// kHz cost 6 % of a core per 4000 states/s, and the controller's proxy age does not move; 8000
  /// leaves a slower host room.
  unsigned watch_budget_hz{8000};
  ArrivalClock clock{steady_arrival};  ///< stamps what arrives, whatever carries it
  /// A sample may be older than its arrival, by its source time. Off in a test whose clock is no
  /// steady one: it does not run as the clients' do.
  bool age_by_source_time{true};
  /// A session stream has to send its OpenSession by then.
  core::Duration open_within{std::chrono::seconds(5)};
  KeepAlive keep_alive{};  ///< of connections whose far end is gone without a word
  ConnectionLimits connections{};
};

/// Session streams that have not sent their OpenSession: so many at a time, of all connections
/// together.
[[nodiscard]] constexpr unsigned unopened_streams(unsigned max_sessions) noexcept {
  return 2 * max_sessions + 64;
}

/// Calls of one connection at a time: every session, every watch, and some that are answered at
/// once. gRPC spends 16 KB on each before the service hears of it.
[[nodiscard]] constexpr unsigned calls_of_connection(unsigned max_sessions) noexcept {
  return 2 * max_sessions + 16;
}

}  // namespace haptic::server
