#include "server/base/thread_setup.hpp"

#include <pthread.h>

#include <csignal>

namespace haptic::server {

void set_thread_up(const char* name) noexcept {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
  pthread_setname_np(pthread_self(), name);
}

}  // namespace haptic::server
