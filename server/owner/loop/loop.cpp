#include "server/owner/loop/loop.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "server/base/thread_setup.hpp"

namespace haptic::server {

LoopBody::LoopBody(std::vector<DeviceUnit*> units, Bell& end_of_tick, core::Duration period,
                   LoopClock& clock, hw::SampleSignal* samples)
    : units_(std::move(units)),
      end_of_tick_(end_of_tick),
      period_(period),
      clock_(clock),
      samples_(samples),
      finish_by_ns_(std::numeric_limits<std::int64_t>::max()) {}

void LoopBody::run() noexcept {
  const core::Duration patience = samples_ != nullptr ? period_ / 4 : core::Duration(0);
  SampleGrid grid(clock_.now() + period_, period_, patience);
  for (;;) {
    const Wake wake =
        samples_ != nullptr ? next_sample(*samples_, grid) : clock_.wait_until(grid.latest());
    const SampleGrid::Tick due = grid.wake(wake.now, wake.suspended, wake.arrival);
    if (samples_ != nullptr) samples_->forget();  // what came while we woke up is read by this tick
    tick(wake, due.report);
    if (due.by_sample) paced_by_sample_.fetch_add(1, std::memory_order_release);
    if (finished(wake.now)) return;
  }
}

/// The end of the wait for the next tick: its sample's arrival, or the earliest moment for a tick
/// if the sample came too early for one, or the timer's if none came.
Wake LoopBody::next_sample(hw::SampleSignal& samples, const SampleGrid& grid) noexcept {
  const Wake wake = clock_.wait_for(samples, grid.latest());
  const core::TimePoint due = wake.arrival ? grid.earliest() : grid.latest();
  if (wake.now >= due) return wake;
  Wake later = clock_.wait_until(due);
  later.suspended += wake.suspended;
  later.arrival = wake.arrival;
  return later;
}

void LoopBody::tick(const Wake& wake, const core::LoopReport& report) noexcept {
  for (DeviceUnit* unit : units_) unit->tick(wake.now, period_, report);
  end_of_tick_.ring();

  ticks_.fetch_add(1, std::memory_order_relaxed);
  skipped_.fetch_add(report.skipped, std::memory_order_relaxed);
  lateness_.add(wake.now, report.lateness);
  tick_time_.add(wake.now, clock_.now() - wake.now);
}

void LoopBody::finish(core::TimePoint latest) noexcept {
  finish_by_ns_.store(latest.time_since_epoch().count(), std::memory_order_release);
}

bool LoopBody::finished(core::TimePoint now) const noexcept {
  const std::int64_t by = finish_by_ns_.load(std::memory_order_acquire);
  if (by == std::numeric_limits<std::int64_t>::max()) return false;
  if (now.time_since_epoch().count() >= by) return true;
  return std::all_of(units_.begin(), units_.end(), [](const DeviceUnit* unit) {
    return unit->state() == core::LifecycleState::kClosing;
  });
}

LoopFacts LoopBody::statistics() const noexcept {
  // First, as it is counted last: never more of them than ticks.
  const std::uint64_t paced_by_sample = paced_by_sample_.load(std::memory_order_acquire);
  return {ticks_.load(std::memory_order_relaxed), skipped_.load(std::memory_order_relaxed),
          paced_by_sample, lateness_.read(), tick_time_.read()};
}

Loop::Loop(const RealtimeRequest& request, core::Duration period, RealtimeHost& host)
    : period_(period) {
  std::future<RealtimeGrant> granted = granted_.get_future();
  thread_ = std::thread([this, request, &host] { live(request, host); });
  try {
    grant_ = granted.get();
  } catch (...) {
    thread_.join();
    throw;
  }
}

Loop::~Loop() {
  finish(core::Duration::zero());
}

void Loop::live(const RealtimeRequest& request, RealtimeHost& host) {
  set_thread_up("loop");
  std::future<LoopBody*> begun = begun_.get_future();
  try {
    granted_.set_value(apply_realtime(request, host));
  } catch (...) {
    granted_.set_exception(std::current_exception());
    return;
  }
  LoopBody* const body = begun.get();
  if (body == nullptr) return;
  for (const DeviceUnit* unit : to_rehearse_) unit->rehearse();
  body->run();
}

void Loop::begin(std::vector<DeviceUnit*> units, Bell& end_of_tick, hw::SampleSignal* samples) {
  to_rehearse_.assign(units.begin(), units.end());
  body_storage_ =
      std::make_unique<LoopBody>(std::move(units), end_of_tick, period_, clock_, samples);
  body_.store(body_storage_.get(), std::memory_order_release);
  begun_.set_value(body_storage_.get());
}

void Loop::finish(core::Duration at_most) {
  if (!thread_.joinable()) return;
  if (body_storage_) {
    body_storage_->finish(clock_.now() + at_most);
  } else {
    begun_.set_value(nullptr);
  }
  thread_.join();
}

LoopFacts Loop::statistics() const noexcept {
  const LoopBody* body = body_.load(std::memory_order_acquire);
  return body != nullptr ? body->statistics() : LoopFacts{};
}

}  // namespace haptic::server
