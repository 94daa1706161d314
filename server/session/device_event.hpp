#pragma once
/// What happened to a device, once each: found by comparing a tick's record with the one before.

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "haptic/core/tick/tick_record.hpp"

namespace haptic::server {

struct DeviceEvent {
  enum class Kind : std::uint8_t {
    kState = 1,         ///< reason "ENGAGED -> ARMED"
    kLost = 2,          ///< force was given up, proxy too old; reason "LOST"
    kFault = 3,         ///< reason: the fault's
    kFaultCleared = 4,  ///< reason: the fault's
    kLeaseExpired = 5,  ///< reason "LEASE_EXPIRED"
    kStaleness = 6,     ///< reason "FRESH -> HOLD"
    kClosing = 7,       ///< reason "CLOSING"
    kTransport = 8,     ///< of a session, not of a record; reason "SAMPLES GRPC -> UDP"
    kLease = 9,         ///< not of a record; reason "LEASE_GRANTED", "LEASE_RESUMED", ...
    kClamp = 10,        ///< not of a record; reason "CLAMPED": a setting was held at the scene's
    kLimiter = 20,      ///< a limit of an actuator began to act; reason: the limiter's
  };
  Kind kind{Kind::kState};
  core::TimePoint time{};  ///< server's steady clock, of the tick
  std::string reason{};    ///< stable
  std::string message{};   ///< for people
  core::DeviceState state{core::DeviceState::kInit};
  std::uint32_t lease_epoch{0};  ///< the lease it happened under; 0: under none
};

/// Compares consecutive records of one device. One thread.
class EventDetector {
 public:
  /// A limit that acts again within this time is the same clamp: one event.
  static constexpr core::Duration kQuiet{std::chrono::seconds(1)};
  /// `stop_reason`: what a person gave with the newest emergency stop, for its event's message.
  void step(const core::TickRecord& record, const std::string& stop_reason,
            std::vector<DeviceEvent>& events);

 private:
  void limiters(const core::TickRecord& record, std::vector<DeviceEvent>& events);

  core::DeviceState state_{core::DeviceState::kInit};
  core::FaultSet faults_{};
  core::Staleness staleness_{core::Staleness::kLost};
  /// Per limiter number, when it last acted; absent: never.
  std::array<std::optional<core::TimePoint>, 32> acted_{};
};

/// Events on their way to one session. Bounded: a client that does not read loses the oldest, and
/// the next event it gets says how many. Any thread.
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
