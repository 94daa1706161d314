#pragma once
/// Writes a device's states, faults and leases to the server's log, on the telemetry's drain.

#include <functional>
#include <string>

#include "server/session/device_event.hpp"
#include "server/telemetry/telemetry.hpp"

namespace haptic::server {

class EventLog final : public RecordListener {
 public:
  /// `holder` returns the client name of the lease's holder; called on the drain's thread.
  EventLog(std::string device, std::function<std::string()> holder);

  void on_record(const core::TickRecord& record) override;

 private:
  void lease(const core::CommandSnapshot& command);

  const std::string device_;
  const std::function<std::string()> holder_;
  EventDetector detector_;
  std::uint32_t tenure_{0};
  bool held_{false};
};

}  // namespace haptic::server
