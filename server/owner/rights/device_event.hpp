#pragma once
/// Events of a device, once each: found by comparing a tick's record with the one before.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "haptic/core/tick/tick_record.hpp"
#include "server/crossing/crossing.hpp"

namespace haptic::server {

/// Compares consecutive records of one device.
class EventDetector {
 public:
  /// A limit that acts again within this time is the same clamp: one event.
  static constexpr core::Duration kQuiet{std::chrono::seconds(1)};
  /// Appends what happened. `stop_reason`: given with the newest emergency stop, for its event's
  /// message. The lease_epoch of the events is the record's.
  void step(const core::TickRecord& record, const std::string& stop_reason,
            std::vector<DeviceEvent>& events);

 private:
  /// Tells what an Engage waits for that was refused for half a second, once for each reason.
  void waits(const core::TickRecord& record, std::vector<DeviceEvent>& events);
  /// Tells the stiffness that the loop allows, if that changed by much.
  void derating(const core::TickRecord& record, std::vector<DeviceEvent>& events);
  void limiters(const core::TickRecord& record, std::vector<DeviceEvent>& events);

  std::uint64_t answered_{0};                  ///< number of the newest Engage that was looked at
  core::TimePoint waits_since_{}, refused_{};  ///< the first and the newest refusal
  std::array<bool, 16> told_of_{};             ///< by verdict, since the first
  core::LifecycleState state_{core::LifecycleState::kInit};
  core::FaultSet faults_{};
  core::Staleness staleness_{core::Staleness::kLost};
  /// Per limiter number, when it last acted; absent: never.
  std::array<std::optional<core::TimePoint>, 32> acted_{};
  double allowed_{1.0};  ///< by the settings' stiffness, of the actuator with the least; as told
  std::optional<core::TimePoint> told_{};  ///< when
};

}  // namespace haptic::server
