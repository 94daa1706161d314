#pragma once
/// The first call of every thread of the server.

#include <pthread.h>

#include <csignal>

namespace haptic::server {

/// For the calling thread: blocks every signal (main alone waits for them) and gives it a name of
/// at most 15 characters, as `top -H` shows it.
inline void set_thread_up(const char* name) noexcept {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
  pthread_setname_np(pthread_self(), name);
}

}  // namespace haptic::server
