#pragma once
/// SIGINT and SIGTERM as a flag that a loop looks at.

#include <csignal>

namespace haptic::examples {

inline volatile std::sig_atomic_t stop_requested = 0;

inline void stop_on_signal() {
  std::signal(SIGINT, [](int) { stop_requested = 1; });
  std::signal(SIGTERM, [](int) { stop_requested = 1; });
}

}  // namespace haptic::examples
