#include "server/base/start_limits.hpp"

#include <pthread.h>
#include <sys/resource.h>

#include <cstring>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

namespace haptic::server {
namespace {

/// One device and one client need about 40.
constexpr rlim_t kLeastDescriptors = 64;
/// One device and one client need about 20; so many are started, and end again.
constexpr std::size_t kLeastThreads = 24;
constexpr std::size_t kSmallStack = 64 * 1024;

void* wait_until_open(void* gate) {
  const std::lock_guard pass(*static_cast<std::mutex*>(gate));
  return nullptr;
}

}  // namespace

std::string lack_of_threads(std::size_t wanted) {
  std::mutex gate;
  std::vector<pthread_t> threads;
  pthread_attr_t small;
  pthread_attr_init(&small);
  pthread_attr_setstacksize(&small, kSmallStack);
  int error = 0;
  {
    const std::lock_guard closed(gate);
    for (pthread_t thread{}; error == 0 && threads.size() < wanted;) {
      error = pthread_create(&thread, &small, wait_until_open, &gate);
      if (error == 0) threads.push_back(thread);
    }
  }
  for (const pthread_t thread : threads) pthread_join(thread, nullptr);
  pthread_attr_destroy(&small);
  if (error == 0) return {};
  return "may start " + std::to_string(threads.size()) +
         " threads (ulimit -u): " + std::strerror(error) + "; needs at least " +
         std::to_string(wanted);
}

void check_memory_limits() {
  struct Least {
    __rlimit_resource which;
    rlim_t bytes;
    const char* words;
  };
  constexpr rlim_t kKilobyte = 1024, kMegabyte = 1024 * kKilobyte;
  // The front's threads have 1 MB of stack, and the owner's need less; its memory is that of a
  // scene with many devices.
  for (const Least& least : {Least{RLIMIT_STACK, 512 * kKilobyte, "stack (ulimit -s)"},
                             Least{RLIMIT_DATA, 128 * kMegabyte, "data (ulimit -d)"},
                             Least{RLIMIT_AS, 256 * kMegabyte, "address space (ulimit -v)"}}) {
    rlimit limit{};
    if (getrlimit(least.which, &limit) != 0 || limit.rlim_cur >= least.bytes) continue;
    throw std::runtime_error("may use " + std::to_string(limit.rlim_cur / kKilobyte) + " KB of " +
                             least.words + ": needs at least " +
                             std::to_string(least.bytes / kKilobyte) + " KB");
  }
}

void check_start_limits() {
  rlimit descriptors{};
  if (getrlimit(RLIMIT_NOFILE, &descriptors) == 0 && descriptors.rlim_cur < kLeastDescriptors) {
    throw std::runtime_error("may open " + std::to_string(descriptors.rlim_cur) +
                             " files at a time (ulimit -n): needs at least " +
                             std::to_string(kLeastDescriptors));
  }
  const std::string lack = lack_of_threads(kLeastThreads);
  if (!lack.empty()) throw std::runtime_error(lack);
}

}  // namespace haptic::server
