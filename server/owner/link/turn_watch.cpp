#include "server/owner/link/turn_watch.hpp"

#include <condition_variable>
#include <mutex>
#include <utility>

#include "server/base/thread_setup.hpp"

namespace haptic::server {

TurnWatch::TurnWatch(std::function<void()> stuck, core::Duration every)
    : stuck_(std::move(stuck)),
      thread_([this, every](const std::stop_token& over) { look(over, every); }) {}

void TurnWatch::look(const std::stop_token& over, core::Duration every) const {
  set_thread_up("link watch");
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any wakes;
  std::uint64_t seen = 0;
  for (int still = 0; !over.stop_requested();) {
    wakes.wait_for(lock, over, every, [] { return false; });
    const std::uint64_t turns = turns_.load(std::memory_order_relaxed);
    still = turns == std::exchange(seen, turns) && turns != 0 ? still + 1 : 0;
    if (still != 0 && still % kLooks == 0) stuck_();
  }
}

}  // namespace haptic::server
