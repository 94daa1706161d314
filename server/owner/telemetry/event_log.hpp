#pragma once
/// Writes what happens to the devices to the server's log: states, faults, leases, limits.

#include "server/crossing/ports.hpp"

namespace haptic::server {

/// How the message of an Engage that waits begins.
inline constexpr const char* kWaits = "force waits: ";

class EventLog final : public FrontPort {
 public:
  /// `owner` must outlive this.
  explicit EventLog(const OwnerPort& owner) : owner_(owner) {}
  void on_event(std::size_t device, const DeviceEvent& event) override;

 private:
  const OwnerPort& owner_;
};

}  // namespace haptic::server
