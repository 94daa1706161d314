#pragma once
/// The border of the owner: requests and samples come in from any thread, records from the
/// telemetry drain; answers, events and states go out to the front. One lock lies at this border;
/// behind it (sessions, ingress, tracker) everything is single-threaded.

#include <memory>
#include <mutex>
#include <vector>

#include "server/crossing/ports.hpp"
#include "server/owner/rights/device_sessions.hpp"
#include "server/owner/rights/session_registry.hpp"
#include "server/owner/telemetry/telemetry.hpp"
#include "server/owner/telemetry/tick_metrics.hpp"

namespace haptic::server {

class Owner final : public OwnerPort {
 public:
  /// Controllers and trackers are limited to `max_sessions`, and so are observers, and watches.
  /// `telemetry` must outlive this.
  explicit Owner(Telemetry& telemetry, unsigned max_sessions = 32);
  ~Owner() override;
  Owner(const Owner&) = delete;
  Owner& operator=(const Owner&) = delete;

  /// The next device, which is that unit of the telemetry. Before any other call; `unit` must
  /// outlive this. `description`: describe() of it, if the caller has that already. Throws
  /// core::SceneError if a state of it may be larger than SerialisedState holds.
  void add(DeviceUnit& unit, const SessionRules& rules, std::string description = {});
  /// Counts every tick from now on. Before the telemetry starts.
  void count_into(std::shared_ptr<TickMetrics> metrics) { metrics_ = std::move(metrics); }
  /// SIGTERM: DeviceSessions::begin_closing() of every device.
  void begin_closing();
  /// The loop has ended, and the telemetry has drained: DeviceSessions::loop_ended() of every
  /// device.
  void loop_ended();
  /// The front's process is gone, and with it every stream: what can be resumed may be.
  void front_gone();
  /// post(), for a caller that passes the verdict on itself. Allocates nothing.
  [[nodiscard]] Verdict accept(const ProxySample& sample);
  [[nodiscard]] Verdict accept(const PoseSample& pose);

  [[nodiscard]] const std::vector<DeviceFacts>& devices() const noexcept override { return facts_; }
  void post(const Request& request) override;
  void post(const ProxySample& sample) override;
  void post(const PoseSample& pose) override;
  [[nodiscard]] DeviceStatus status(std::size_t device) const override;
  /// The state of the newest record. The telemetry drain's thread only.
  [[nodiscard]] const v1::DeviceState& newest(std::size_t device) const;

 private:
  class Device;
  /// Calls `act` under the lock and hands out what came of it: events under the lock, so that they
  /// keep their order; answers when it is free again, because a front may post its next request
  /// from within one.
  template <typename Act>
  void serve(const Act& act);
  void handle(const Request& request, std::vector<Answer>& answers);
  void tell(const Judged& judged);
  void on_record(Device& device, const core::TickRecord& record);

  Telemetry& telemetry_;
  std::vector<DeviceFacts> facts_;
  std::vector<std::unique_ptr<Device>> devices_;
  std::shared_ptr<TickMetrics> metrics_{};  ///< null: ticks are not counted

  mutable std::mutex mutex_;
  SessionRegistry registry_;
};

}  // namespace haptic::server
