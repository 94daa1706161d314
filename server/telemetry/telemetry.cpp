#include "server/telemetry/telemetry.hpp"

#include <sys/prctl.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>

#include "server/base/thread_setup.hpp"

namespace haptic::server {

namespace {
/// How long after a tick's deadline its end is watched for: the loop's usual lateness and a tick.
constexpr core::Duration kPatience = std::chrono::microseconds(60);
}  // namespace

/// One unit's records on their way to its listeners. A listener is called without the mutex held,
/// so that it may add and remove; `called_` says who is being called, so that remove() can wait.
class Telemetry::Channel {
 public:
  explicit Channel(DeviceUnit& unit) : unit_(unit) {}

  void add(RecordListener* listener, ListenerRank rank) {
    const std::lock_guard lock(mutex_);
    const auto after = std::upper_bound(
        listeners_.begin(), listeners_.end(), rank,
        [](ListenerRank wanted, const Listener& other) { return wanted < other.rank; });
    listeners_.insert(after, {listener, rank});
  }

  void remove(RecordListener* listener) {
    std::unique_lock lock(mutex_);
    std::erase_if(listeners_, [&](const Listener& other) { return other.call == listener; });
    if (caller_ == std::this_thread::get_id()) return;
    call_ended_.wait(lock, [&] { return called_ != listener; });
  }

  void drain() {
    const core::TickRecord* record = unit_.records.front();
    if (record == nullptr) return;
    listeners_at_start();
    for (; record != nullptr; record = unit_.records.front()) {
      keep(*record);
      unit_.records.pop();
      // Only this thread writes newest_: reading it here needs no lock.
      for (RecordListener* listener : round_) {
        call(listener, [&] { listener->on_record(newest_); });
      }
    }
    for (RecordListener* listener : round_) call(listener, [&] { listener->on_newest(newest_); });
  }

  /// Deadline of the tick after the newest record's. The drain's thread only.
  [[nodiscard]] core::TimePoint next_tick() const {
    return newest_.input.now - newest_.input.loop.lateness + newest_.input.period;
  }

  [[nodiscard]] core::TickRecord newest() const {
    const std::lock_guard lock(newest_mutex_);
    return newest_;
  }

 private:
  struct Listener {
    RecordListener* call{nullptr};
    ListenerRank rank{ListenerRank::kService};
  };

  void keep(const core::TickRecord& record) {
    const std::lock_guard lock(newest_mutex_);
    newest_ = record;
  }

  void listeners_at_start() {
    const std::lock_guard lock(mutex_);
    round_.clear();
    for (const Listener& listener : listeners_) round_.push_back(listener.call);
  }

  /// Calls a listener, unless it was removed meanwhile.
  template <typename Call>
  void call(RecordListener* listener, const Call& run) {
    {
      const std::lock_guard lock(mutex_);
      const bool still_there = std::any_of(listeners_.begin(), listeners_.end(),
                                           [&](const Listener& l) { return l.call == listener; });
      if (!still_there) return;
      called_ = listener;
      caller_ = std::this_thread::get_id();
    }
    run();
    {
      const std::lock_guard lock(mutex_);
      called_ = nullptr;
      caller_ = {};
    }
    call_ended_.notify_all();
  }

  DeviceUnit& unit_;

  std::mutex mutex_;
  std::condition_variable call_ended_;
  std::vector<Listener> listeners_;
  RecordListener* called_{nullptr};
  std::thread::id caller_{};

  mutable std::mutex newest_mutex_;
  core::TickRecord newest_{};

  std::vector<RecordListener*> round_;  ///< the drain's own
};

Telemetry::Telemetry(const std::vector<DeviceUnit*>& units) {
  channels_.reserve(units.size());
  for (DeviceUnit* unit : units) channels_.push_back(std::make_unique<Channel>(*unit));
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
}

void Telemetry::serve() noexcept {
  set_thread_up("telemetry");
  if (may_watch_) prctl(PR_SET_TIMERSLACK, 1UL, 0, 0, 0);  // it has an appointment with the loop
  for (;;) {
    const std::uint32_t heard = bell_.rings();
    const bool last_round = stopping_.load();
    drain();
    if (last_round) return;
    wait_for_ring(heard);
  }
}

void Telemetry::wait_for_ring(std::uint32_t heard) noexcept {
  if (may_watch_ && watchers_.load(std::memory_order_relaxed) > 0) {
    core::TimePoint next{};
    for (const auto& channel : channels_) next = std::max(next, channel->next_tick());
    bell_.meet(heard, next, kPatience);
    if (bell_.rings() != heard) return;
  }
  bell_.sleep(heard);
}

void Telemetry::drain() {
  for (const auto& channel : channels_) channel->drain();
}

void Telemetry::add(std::size_t unit, RecordListener* listener, ListenerRank rank) {
  channels_.at(unit)->add(listener, rank);
}

void Telemetry::remove(std::size_t unit, RecordListener* listener) {
  channels_.at(unit)->remove(listener);
}

core::TickRecord Telemetry::newest(std::size_t unit) const {
  return channels_.at(unit)->newest();
}

}  // namespace haptic::server
