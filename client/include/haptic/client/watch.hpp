#pragma once
/// States and events of a device without a session. Connection::watch() begins it.
///
/// The callbacks run on a thread of gRPC, one at a time per watch. If a callback is slow, states
/// wait in the connection's buffers, and the server leaves states out once those are full. To get
/// the newest state always, open a session with SessionOptions::observer.

#include <cstdint>
#include <optional>

#include "haptic/client/error.hpp"

namespace haptic::client {

class Watch {
 public:
  /// Ends the watch; waits for a running callback. Must not run in one of its own callbacks.
  virtual ~Watch() = default;
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;
  /// False once the stream ended; error() says why.
  [[nodiscard]] virtual bool running() const = 0;
  [[nodiscard]] virtual std::optional<ClientError> error() const = 0;
  /// Number of states that the server left out because this watch was too slow for them.
  [[nodiscard]] virtual std::uint64_t conflated() const = 0;

 protected:
  Watch() = default;
};

}  // namespace haptic::client
