#pragma once
/// The loop: one thread, absolute deadlines, every unit in order, then the telemetry's bell. It owns
/// its thread from prepare() to join(); the thread blocks all signals.

#include <atomic>
#include <future>
#include <thread>
#include <vector>

#include "server/rt/device_unit.hpp"
#include "server/rt/loop_statistics.hpp"
#include "server/rt/realtime.hpp"
#include "server/telemetry/telemetry.hpp"

namespace haptic::server {

class Loop {
 public:
  explicit Loop(core::Duration period);
  ~Loop();
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  /// Starts the thread and applies the request to it; it then waits for run(). Throws RealtimeError.
  RealtimeFacts prepare(const RealtimeRequest& request);
  /// Ticks from now on. Units and telemetry must outlive the loop.
  void run(std::vector<DeviceUnit*> units, Telemetry& telemetry);
  /// Ends the loop once every unit is CLOSING, or after `longest` in any case; joins.
  void finish(core::Duration longest);

  /// Any thread.
  [[nodiscard]] LoopFacts facts() const;

 private:
  void main();
  [[nodiscard]] bool all_closing() const noexcept;

  const core::Duration period_;
  std::vector<DeviceUnit*> units_{};
  Telemetry* telemetry_{nullptr};
  SlidingPercentiles lateness_{};
  SlidingPercentiles work_{};
  std::atomic<std::uint64_t> ticks_{0};
  std::atomic<std::uint64_t> skipped_{0};
  std::atomic<bool> finishing_{false};
  std::atomic<core::TimePoint> give_up_{core::TimePoint::max()};
  std::promise<bool> go_{};
  bool told_{false};
  std::thread thread_{};
};

}  // namespace haptic::server
