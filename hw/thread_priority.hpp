#pragma once
/// Real-time scheduling for threads that keep a device's millisecond.

#include <pthread.h>
#include <sched.h>

namespace haptic::hw {

/// Asks for SCHED_FIFO for the calling thread. Without that right (hapticd says so at its start)
/// the thread still keeps its times if the machine is not busy.
inline void ask_for_priority(int priority) noexcept {
  sched_param parameters{};
  parameters.sched_priority = priority;
  static_cast<void>(pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters));
}

}  // namespace haptic::hw
