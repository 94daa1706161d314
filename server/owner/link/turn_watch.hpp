#pragma once
/// Looks whether a thread still turns, with a thread of its own.

#include <atomic>
#include <functional>
#include <stop_token>
#include <thread>

#include "haptic/core/time.hpp"

namespace haptic::server {

class TurnWatch {
 public:
  /// Looks in a row that saw no turn; counted, so that a host that was suspended is no reason.
  static constexpr int kLooks = 10;

  /// `stuck`: called on the watch's thread after kLooks looks, `every` apart, and again after as
  /// many.
  explicit TurnWatch(std::function<void()> stuck,
                     core::Duration every = std::chrono::milliseconds(100));

  /// The watched thread, in each turn. It is watched from its first one on.
  void turned() noexcept { turns_.fetch_add(1, std::memory_order_relaxed); }
  /// It ends in order.
  void end() { thread_ = {}; }

 private:
  void look(const std::stop_token& over, core::Duration every) const;

  const std::function<void()> stuck_;
  std::atomic<std::uint64_t> turns_{0};
  std::jthread thread_;
};

}  // namespace haptic::server
