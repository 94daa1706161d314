#pragma once
/// The telemetry drain: one thread that empties every unit's ring and shows each record, where it
/// lies in the ring, to those who listen. The loop wakes it with a futex and never waits for it.

#include <atomic>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "haptic/core/tick/tick_record.hpp"
#include "server/base/bell.hpp"
#include "server/owner/loop/device_unit.hpp"

namespace haptic::server {

/// Called on the drain's thread. Must not block; may start asynchronous writes.
class RecordListener {
 public:
  virtual ~RecordListener() = default;
  /// Every record of the unit, in order, none left out (but those counted as dropped).
  virtual void on_record(const core::TickRecord& record) = 0;
  /// No record came after this one yet. For listeners that leave out records.
  virtual void on_newest(const core::TickRecord& record) { static_cast<void>(record); }
};

class Telemetry {
 public:
  /// The units must outlive the telemetry. start() and stop() own the thread; without start() a
  /// test calls drain() itself.
  explicit Telemetry(const std::vector<DeviceUnit*>& units);
  ~Telemetry();

  void start();
  void stop();

  /// Empties every ring once, on the caller's thread. One thread at a time.
  void drain();

  /// `unit`: index in the constructor's list. Listeners are called in the order in which they were
  /// added: first what sessions and force depend on. Any thread, but not from within a listener's
  /// call. Both wait for the round of calls that is under way, so that after remove() the listener
  /// is not called again: do not hold a lock that a listener takes.
  void add(std::size_t unit, RecordListener* listener);
  void remove(std::size_t unit, RecordListener* listener);

  /// Lets the drain busy-wait for the end of the tick, which saves a wake-up on the way to the
  /// streams and costs some microseconds per tick. Only if the loop runs on meanwhile: with
  /// real-time priority and a second core. The drain itself then has the lowest real-time priority.
  /// Before start().
  void allow_watching(bool allowed) noexcept { may_watch_ = allowed; }
  /// `keep_awake` is told true when the first latency-sensitive client begins, and false when the
  /// last one ended, or at stop(). Before start().
  void on_watched(std::function<void(bool awake)> keep_awake) {
    keep_awake_ = std::move(keep_awake);
  }
  /// Number of latency-sensitive clients: +1 when one begins, -1 when it ends. Any thread, one at a
  /// time.
  void watch(int change);

  /// Wakes the drain: the loop rings it at the end of every tick.
  [[nodiscard]] Bell& bell() noexcept { return bell_; }

 private:
  struct Channel {
    DeviceUnit* unit{nullptr};
    std::vector<RecordListener*> listeners{};
    core::TimePoint next_tick{};  ///< the drain's alone
  };
  void serve() noexcept;
  void wait_for_ring(std::uint32_t heard) noexcept;

  mutable std::mutex mutex_;  ///< held while the listeners are called
  std::vector<Channel> channels_;
  Bell bell_;
  bool may_watch_{false};
  std::function<void(bool)> keep_awake_{[](bool) {}};
  std::atomic<int> watchers_{0};
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace haptic::server
