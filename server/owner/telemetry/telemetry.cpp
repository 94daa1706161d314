#include "server/owner/telemetry/telemetry.hpp"

#include <sys/prctl.h>

#include <algorithm>

#include "server/base/thread_setup.hpp"

namespace haptic::server {

namespace {
/// How long after a tick's deadline its end is watched for: the loop's usual lateness and a tick.
constexpr core::Duration kPatience = std::chrono::microseconds(60);
}  // namespace

Telemetry::Telemetry(const std::vector<DeviceUnit*>& units) {
  for (DeviceUnit* unit : units) channels_.push_back({unit});
}

Telemetry::~Telemetry() {
  stop();
}

void Telemetry::start() {
  if (thread_.joinable()) return;
  stopping_.store(false);
  thread_ = std::thread([this] { serve(); });
}

void Telemetry::stop() {
  if (!thread_.joinable()) return;
  stopping_.store(true);
  bell_.ring();
  thread_.join();
  if (watchers_.load() > 0) keep_awake_(false);
}

void Telemetry::serve() noexcept {
  set_thread_up("telemetry", may_watch_);
  if (may_watch_) prctl(PR_SET_TIMERSLACK, 1UL, 0, 0, 0);  // it has an appointment with the loop
  for (;;) {
    const std::uint32_t heard = bell_.rings();
    const bool last_round = stopping_.load();
    drain();
    if (last_round) return;
    wait_for_ring(heard);
  }
}

void Telemetry::watch(int change) {
  const int before = watchers_.fetch_add(change, std::memory_order_relaxed);
  const bool awake = before + change > 0;
  if (awake != (before > 0)) keep_awake_(awake);
}

void Telemetry::wait_for_ring(std::uint32_t heard) noexcept {
  if (may_watch_ && watchers_.load(std::memory_order_relaxed) > 0) {
    core::TimePoint next{};
    for (const Channel& channel : channels_) next = std::max(next, channel.next_tick);
    bell_.meet(heard, next, kPatience);
    if (bell_.rings() != heard) return;
  }
  bell_.sleep(heard);
}

void Telemetry::drain() {
  const std::lock_guard lock(mutex_);
  for (Channel& channel : channels_) {
    core::Ring<core::TickRecord>& records = channel.unit->records;
    for (; const core::TickRecord* const record = records.front(); records.pop()) {
      for (RecordListener* listener : channel.listeners) listener->on_record(*record);
      if (!records.last()) continue;
      for (RecordListener* listener : channel.listeners) listener->on_newest(*record);
      const core::TickInput& in = record->input;
      channel.next_tick = in.now - in.loop.lateness + in.period;
    }
  }
}

void Telemetry::add(std::size_t unit, RecordListener* listener) {
  const std::lock_guard lock(mutex_);
  channels_.at(unit).listeners.push_back(listener);
}

void Telemetry::remove(std::size_t unit, RecordListener* listener) {
  const std::lock_guard lock(mutex_);
  std::erase(channels_.at(unit).listeners, listener);
}

}  // namespace haptic::server
