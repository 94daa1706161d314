#pragma once
/// Wakes a thread of this process that waits in poll(). No other process holds its descriptor.

#include "server/base/descriptor.hpp"

namespace haptic::server {

class WakeUp {
 public:
  /// Throws core::TransportError.
  WakeUp();
  /// Any thread.
  void wake() const noexcept;
  /// The thread that waits: readable after wake(), until forget().
  [[nodiscard]] int descriptor() const noexcept { return event_.get(); }
  void forget() const noexcept;

 private:
  Descriptor event_;
};

}  // namespace haptic::server
