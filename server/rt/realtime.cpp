#include "server/rt/realtime.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>

#include "haptic/core/error.hpp"

namespace haptic::server {

namespace {

constexpr unsigned kCapIpcLock = 14;  // linux/capability.h

bool has_capability(unsigned number) {
  std::ifstream status("/proc/self/status");
  std::string line;
  while (std::getline(status, line)) {
    if (line.rfind("CapEff:", 0) == 0) {
      return ((std::stoull(line.substr(7), nullptr, 16) >> number) & 1U) != 0;
    }
  }
  return false;
}

/// nullptr-like empty string: locked. Otherwise why not.
std::string lock_memory() {
  if (!has_capability(kCapIpcLock)) {
    // Under a finite limit MCL_FUTURE would let the next thread's stack fail and end the process.
    rlimit limit{};
    getrlimit(RLIMIT_MEMLOCK, &limit);
    if (limit.rlim_max == RLIM_INFINITY && limit.rlim_cur != RLIM_INFINITY) {
      limit.rlim_cur = RLIM_INFINITY;
      setrlimit(RLIMIT_MEMLOCK, &limit);
      getrlimit(RLIMIT_MEMLOCK, &limit);
    }
    if (limit.rlim_cur != RLIM_INFINITY) {
      return "RLIMIT_MEMLOCK is " + std::to_string(limit.rlim_cur / 1024) +
             " kB and CAP_IPC_LOCK is missing";
    }
  }
  if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) return std::strerror(errno);
  return {};
}

std::string set_fifo(int priority) {
  sched_param parameter{};
  parameter.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter);
  return error == 0 ? std::string() : std::strerror(error);
}

std::string pin(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<unsigned>(cpu), &set);
  const int error = pthread_setaffinity_np(pthread_self(), sizeof set, &set);
  return error == 0 ? std::string() : std::strerror(error);
}

/// Touches the stack that the loop will use, so that no tick takes the page fault.
void prefault_stack() {
  constexpr std::size_t kBytes = 256 * 1024;
  volatile char stack[kBytes];
  for (std::size_t i = 0; i < kBytes; i += 1024) stack[i] = 0;
  static_cast<void>(stack[0]);
}

}  // namespace

RealtimeFacts apply_realtime(const RealtimeRequest& request) {
  RealtimeFacts facts;
  prefault_stack();
  if (request.mode == RealtimeMode::kOff) {
    facts.requested = "off";
    facts.grade = "best-effort";
    facts.explanation =
        "real-time scheduling was not asked for: any other program may delay a tick";
    return facts;
  }
  facts.requested = request.mode == RealtimeMode::kRequire ? "require" : "try";

  const std::string no_fifo = set_fifo(request.priority);
  facts.sched_fifo = no_fifo.empty();
  facts.priority = facts.sched_fifo ? request.priority : 0;
  const std::string no_lock = lock_memory();
  facts.memory_locked = no_lock.empty();
  facts.timer_slack = prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL) == 0;
  std::string no_pin;
  if (request.cpu) {
    no_pin = pin(*request.cpu);
    if (no_pin.empty()) facts.cpu = *request.cpu;
  }

  if (facts.sched_fifo) {
    facts.explanation = "SCHED_FIFO " + std::to_string(facts.priority) +
                        ": only the kernel and higher priorities may delay a tick";
  } else {
    facts.explanation = "SCHED_FIFO refused (" + no_fifo +
                        "): any other program may delay a tick, a late loop is a fault after 20 ms "
                        "instead of 8 ms; run as root, or grant CAP_SYS_NICE or an rtprio limit";
  }
  facts.explanation += facts.memory_locked
                           ? "; memory is locked as it is touched"
                           : "; memory is not locked (" + no_lock +
                                 "): a page fault may delay a tick; raise the memlock limit";
  if (!no_pin.empty()) {
    facts.explanation +=
        "; CPU " + std::to_string(*request.cpu) + " refused (" + no_pin + "): not pinned";
  }
  const bool whole = facts.sched_fifo && facts.memory_locked && no_pin.empty();
  facts.grade = whole ? "real-time" : "degraded";
  if (request.mode == RealtimeMode::kRequire && !whole) {
    throw core::RealtimeError("--realtime=require: " + facts.explanation);
  }
  return facts;
}

}  // namespace haptic::server
