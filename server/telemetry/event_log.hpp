#pragma once
/// What happened to a device, as lines of the log; on the telemetry's thread, never the loop's.

#include <string>
#include <vector>

#include "server/session/device_event.hpp"
#include "server/telemetry/telemetry.hpp"

namespace haptic::server {

class EventLog final : public RecordListener {
 public:
  explicit EventLog(std::string device) : device_(std::move(device)) {}
  void on_record(const core::TickRecord& record) override;

 private:
  std::string device_;
  EventDetector detector_{};
  std::vector<DeviceEvent> events_{};
  std::uint32_t epoch_{0};
  bool held_{false};
};

}  // namespace haptic::server
