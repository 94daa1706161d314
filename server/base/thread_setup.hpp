#pragma once
/// The first call of every thread of the server.

#include <pthread.h>
#include <sched.h>

#include <csignal>

namespace haptic::server {

/// For the calling thread: blocks every signal (main alone waits for them) and gives it a name of
/// at most 15 characters, as `top -H` shows it. `realtime`: SCHED_FIFO too, at the lowest priority,
/// so that it waits for the loop only and not for ordinary programs.
inline void set_thread_up(const char* name, bool realtime = false) noexcept {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
  pthread_setname_np(pthread_self(), name);
  const sched_param lowest{1};
  if (realtime) sched_setscheduler(0, SCHED_FIFO, &lowest);
}

}  // namespace haptic::server
