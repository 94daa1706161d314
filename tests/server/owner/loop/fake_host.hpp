#pragma once
/// Hosts of all kinds, as a test describes them.

#include <cerrno>

#include "server/owner/loop/realtime.hpp"

namespace haptic::test {

using server::RealtimeHost;
using server::ResourceLimit;

/// A host that grants everything, until a test takes something away.
class FakeHost final : public RealtimeHost {
 public:
  int highest_priority{99};
  bool sys_nice{true};
  ResourceLimit rtprio{0, 0};
  std::optional<double> share{0.95};
  int slack_error{0};
  int cpu_error{0};
  ResourceLimit memlock{8192 * 1024, 8192 * 1024};
  bool ipc_lock{true};
  int lock_error{0};
  int idle_error{0};

  int locks{0};
  int raises{0};
  int fifo_calls{0};
  bool stack_touched{false};
  bool kept_awake{false};

  int set_fifo(int priority) override {
    ++fifo_calls;
    return priority <= highest_priority ? 0 : EPERM;
  }
  ResourceLimit priority_limit() override { return rtprio; }
  bool may_set_any_priority() override { return sys_nice; }
  std::optional<double> realtime_share() override { return share; }
  int set_timer_slack_ns(unsigned long) override { return slack_error; }
  int set_cpu(int) override { return cpu_error; }
  ResourceLimit memory_limit() override { return memlock; }
  int raise_memory_limit() override {
    ++raises;
    memlock.soft = memlock.hard;
    return 0;
  }
  bool may_lock_any_memory() override { return ipc_lock; }
  int lock_memory() override {
    ++locks;
    return lock_error;
  }
  int open_idle_latency() override { return idle_error; }
  void keep_awake(bool awake) noexcept override { kept_awake = awake; }
  void touch_stack() override { stack_touched = true; }
};

/// A container without SYS_NICE and IPC_LOCK.
inline void take_everything_away(FakeHost& host) {
  host.highest_priority = 0;
  host.sys_nice = false;
  host.ipc_lock = false;
  host.idle_error = EACCES;
}

}  // namespace haptic::test
