#pragma once
/// Telemetry without a session.
///
/// Threads: the callbacks run on a thread of gRPC, one at a time per watch. The next message is read
/// when a callback returned, so that a slow one conflates at the server once the connection's buffers
/// are full; a fast loop uses a session as observer, which conflates at once.

#include <memory>
#include <optional>

#include "haptic/client/error.hpp"
#include "haptic/client/types.hpp"

namespace haptic::client {

/// Telemetry of a device until destroyed; not in one of its own callbacks.
class Watch {
 public:
  ~Watch();
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;
  /// False once the stream ended; error() says why.
  [[nodiscard]] bool running() const;
  [[nodiscard]] std::optional<ClientError> error() const;
  /// States the server left out because it or this stream was busy.
  [[nodiscard]] std::uint64_t conflated() const;

 private:
  friend class Connection;
  class Impl;
  explicit Watch(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic::client
