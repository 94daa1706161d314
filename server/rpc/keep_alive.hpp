#pragma once
/// How long a connection lives whose far end gives no sign of life (proto/README.md, "Every
/// limit"). Force does not wait for that: liveness is the data
/// (proto/README.md#staleness-and-gain). This only gives its memory back.

#include <chrono>

#include "haptic/core/time.hpp"

namespace haptic::server {

struct KeepAlive {
  /// A far end that was silent this long is asked for a sign of life (an HTTP/2 PING).
  core::Duration ask_after{std::chrono::seconds(10)};
  /// It has this long to answer. Well above 5 s: at that pace gRPC looks after the connection of a
  /// client without an open call, and what that asks next must not find it closed.
  core::Duration answer_within{std::chrono::seconds(20)};

  [[nodiscard]] constexpr core::Duration given_up_after() const {
    return ask_after + answer_within;
  }
};

}  // namespace haptic::server
