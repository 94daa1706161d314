#pragma once
/// Says how calm the host was: the largest delay of a thread that only sleeps, 1 ms at a time.
/// A remark for the table; no verdict depends on it.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <string>
#include <thread>

namespace haptic::test {

class HostStall {
 public:
  HostStall() : thread_([this] { watch(); }) {}
  ~HostStall() {
    running_ = false;
    thread_.join();
  }
  HostStall(const HostStall&) = delete;
  HostStall& operator=(const HostStall&) = delete;

  [[nodiscard]] std::string text() const {
    return "largest stall of a bare timer thread " + std::to_string(largest_.load().count()) +
           " ms";
  }

 private:
  void watch() {
    using Clock = std::chrono::steady_clock;
    while (running_) {
      const Clock::time_point due = Clock::now() + std::chrono::milliseconds(1);
      std::this_thread::sleep_until(due);
      const auto late = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - due);
      largest_ = std::max(largest_.load(), late);
    }
  }

  std::atomic<std::chrono::milliseconds> largest_{std::chrono::milliseconds(0)};
  std::atomic<bool> running_{true};
  std::thread thread_;  ///< last: it uses the members above
};

}  // namespace haptic::test
