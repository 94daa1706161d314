#pragma once
/// Events on their way to one session or watch.

#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>

#include "server/crossing/crossing.hpp"

namespace haptic::server {

/// Bounded: a client that does not read loses the oldest, and the next event it gets says how many.
/// Any thread.
class EventQueue {
 public:
  static constexpr std::size_t kCapacity = 256;
  void push(const DeviceEvent& event);
  [[nodiscard]] std::optional<DeviceEvent> pop();
  [[nodiscard]] std::uint64_t dropped() const;

 private:
  mutable std::mutex mutex_;
  std::deque<DeviceEvent> events_;
  std::uint64_t dropped_{0};
  std::uint64_t dropped_untold_{0};
};

}  // namespace haptic::server
