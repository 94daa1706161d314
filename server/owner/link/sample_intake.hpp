#pragma once
/// Samples on their way from the memory that a front shares to their device's session. Two threads
/// take them: the loop's just before a tick, so that no sample waits for a thread to wake up, and
/// the front link's, which also takes what the loop left and tells the front what came of each.

#include <atomic>
#include <vector>

#include "server/crossing/shared_layout.hpp"
#include "server/owner/link/from_front.hpp"
#include "server/owner/link/publisher.hpp"
#include "server/owner/rights/owner.hpp"

namespace haptic::server {

class SampleIntake {
 public:
  /// Samples of the proxy, and poses, that the loop takes before one tick, for all devices.
  static constexpr int kPerTick = 4;
  /// The same for a turn of the front link. The owner's lock is free between two turns.
  static constexpr int kPerTurn = 32;

  /// Both must outlive this.
  SampleIntake(Owner& owner, Publisher& publisher);

  /// The samples of the front whose pages these are, and no other front's; null: of none. When it
  /// returns, no thread reads the pages before.
  void serve(const FrontsPages* pages);
  /// The front link's thread. True: there may be more.
  [[nodiscard]] bool take();
  /// The loop's thread: the oldest kPerTick, in order. It waits for no lock, allocates nothing and
  /// wakes no thread. What it leaves, as more waits or another thread holds the owner's lock, the
  /// front link takes. A tick for which no sample waits leaves that lock alone: the telemetry's
  /// core had it last.
  void take_for_tick() noexcept;

 private:
  [[nodiscard]] bool sample_waits() noexcept;
  /// At most `most` of each kind. True: there may be more.
  bool take(int most, const Owner::Turn& turn);

  Owner& owner_;
  Publisher& publisher_;

  // Behind the owner's lock.
  const FrontsPages* pages_{nullptr};
  Inbox<ProxySample, 256>::Cursor proxies_{};
  Inbox<PoseSample, 64>::Cursor poses_{};
  ProxySample sample_{};                                      ///< scratch
  std::vector<ArrivalOrder> proxy_arrivals_, pose_arrivals_;  ///< per device
  std::uint64_t judged_{0};

  // The loop looks at these without that lock; serve() waits until it does not look. They have a
  // cache line of their own, which other threads touch only if there is something new. So the line
  // stays in the cache of the loop's core.
  alignas(64) std::atomic<const FrontsPages*> looked_at_{nullptr};
  std::atomic<bool> looking_{false};
  std::atomic<std::uint64_t> proxies_taken_{0}, poses_taken_{0};

  alignas(64) std::uint64_t told_{0};  ///< the front link's: of judged_
};

}  // namespace haptic::server
