#pragma once
/// The 1 kHz loop: one thread that waits for each deadline, or for each sample of the device that
/// paces it, ticks every unit in order and rings a bell. It waits for no mutex, and all signals
/// are blocked on it.
///
///   construct          the thread starts, gets its real-time grant, and waits
///   begin(units)       rehearses the units, then ticks
///   finish(at_most)    ticks on until every unit is CLOSING, or the time is up; then the thread
///   ends
///
/// The grant comes first because the units are built with what it says (loop_late_fault).

#include <atomic>
#include <future>
#include <memory>
#include <thread>
#include <vector>

#include "server/base/bell.hpp"
#include "server/crossing/server_facts.hpp"
#include "server/owner/loop/device_unit.hpp"
#include "server/owner/loop/loop_clock.hpp"
#include "server/owner/loop/realtime.hpp"
#include "server/owner/loop/sample_grid.hpp"

namespace haptic::server {

/// The loop's work without its thread: a test runs it on virtual time.
class LoopBody {
 public:
  /// All that is passed must outlive the body. `end_of_tick` rings after every tick. `samples`: of
  /// the unit whose device paces the loop; null: the timer does.
  LoopBody(std::vector<DeviceUnit*> units, Bell& end_of_tick, core::Duration period,
           LoopClock& clock, hw::SampleSignal* samples = nullptr);

  /// Ticks until finish() and its conditions. Allocates nothing.
  void run() noexcept;
  /// Any thread: run() returns after the tick in which every unit is CLOSING, or the first one at
  /// or after `latest`.
  void finish(core::TimePoint latest) noexcept;

  [[nodiscard]] LoopFacts statistics() const noexcept;

 private:
  [[nodiscard]] Wake next_sample(hw::SampleSignal& samples, const SampleGrid& grid) noexcept;
  void tick(const Wake& wake, const core::LoopReport& report) noexcept;
  [[nodiscard]] bool finished(core::TimePoint now) const noexcept;

  const std::vector<DeviceUnit*> units_;
  Bell& end_of_tick_;
  const core::Duration period_;
  LoopClock& clock_;
  hw::SampleSignal* const samples_;

  std::atomic<std::int64_t> finish_by_ns_;
  std::atomic<std::uint64_t> ticks_{0};
  std::atomic<std::uint64_t> skipped_{0};
  std::atomic<std::uint64_t> paced_by_sample_{0};
  RollingHistogram lateness_;
  RollingHistogram tick_time_;
};

class Loop {
 public:
  /// Returns when the thread has its grant. Throws RealtimeError (mode kRequire).
  Loop(const RealtimeRequest& request, core::Duration period, RealtimeHost& host = real_host());
  /// finish(0).
  ~Loop();
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  [[nodiscard]] const RealtimeGrant& grant() const noexcept { return grant_; }

  /// Once. The arguments are LoopBody's and must outlive the loop.
  void begin(std::vector<DeviceUnit*> units, Bell& end_of_tick,
             hw::SampleSignal* samples = nullptr);
  /// Returns when the thread has ended. Idempotent.
  void finish(core::Duration at_most);

  /// Any thread; zeros before begin().
  [[nodiscard]] LoopFacts statistics() const noexcept;

 private:
  void live(const RealtimeRequest& request, RealtimeHost& host);

  const core::Duration period_;
  RealtimeGrant grant_{};
  MonotonicClock clock_{};
  std::unique_ptr<LoopBody> body_storage_;
  std::vector<const DeviceUnit*> to_rehearse_;
  std::atomic<LoopBody*> body_{nullptr};  ///< of body_storage_, for statistics()
  std::promise<RealtimeGrant> granted_;
  std::promise<LoopBody*> begun_;  ///< nullptr: end without a tick
  std::thread thread_;
};

}  // namespace haptic::server
