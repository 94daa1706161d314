#pragma once
/// Time that this thread spent on a CPU: what else runs on the machine does not count.

#include <ctime>

namespace haptic::test {

/// ns since some instant.
[[nodiscard]] inline double cpu_ns() noexcept {
  std::timespec now{};
  static_cast<void>(::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now));
  return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}

}  // namespace haptic::test
