#pragma once
/// Waiting for a condition on the real clock.

#include <chrono>
#include <thread>

namespace haptic::test {

/// Polls `condition` until it holds or `limit` has passed. Returns whether it holds.
template <typename Condition>
[[nodiscard]] bool within(std::chrono::milliseconds limit, Condition condition) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (std::chrono::steady_clock::now() < end) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return condition();
}

/// With a limit that a busy machine keeps too: a rule is tested, not the machine.
template <typename Condition>
[[nodiscard]] bool eventually(Condition condition) {
  return within(std::chrono::seconds(60), condition);
}

}  // namespace haptic::test
