#include <chrono>
#include <csignal>

#include "commands.hpp"

namespace haptic::ctl {

namespace {
volatile std::sig_atomic_t interrupted = 0;
}

bool go_on(double seconds) {
  using Clock = std::chrono::steady_clock;
  static const Clock::time_point start = [] {
    std::signal(SIGINT, [](int) { interrupted = 1; });
    std::signal(SIGTERM, [](int) { interrupted = 1; });
    return Clock::now();
  }();
  return interrupted == 0 &&
         (seconds <= 0.0 || std::chrono::duration<double>(Clock::now() - start).count() < seconds);
}

}  // namespace haptic::ctl
