#pragma once
/// The operating system's side of realtime.hpp: one method per question, so that a test can answer
/// as a container, a laptop or a real-time kernel would. Errors are errno values; 0 is success.

#include <cstdint>
#include <optional>

namespace haptic::server {

/// A resource limit in its own unit; absent: unlimited.
struct ResourceLimit {
  std::optional<std::uint64_t> soft{};
  std::optional<std::uint64_t> hard{};
};

class RealtimeHost {
 public:
  virtual ~RealtimeHost() = default;
  RealtimeHost(const RealtimeHost&) = delete;
  RealtimeHost& operator=(const RealtimeHost&) = delete;

  /// SCHED_FIFO for the calling thread.
  virtual int set_fifo(int priority) = 0;
  /// RLIMIT_RTPRIO: the highest priority without CAP_SYS_NICE; 0: none.
  virtual ResourceLimit priority_limit() = 0;
  /// CAP_SYS_NICE is effective for the calling thread.
  virtual bool may_set_any_priority() = 0;
  /// Microseconds per period that all real-time threads together may run, over that period;
  /// absent: no such limit. /proc/sys/kernel/sched_rt_{runtime,period}_us.
  virtual std::optional<double> realtime_share() = 0;

  /// Wake-ups of the calling thread may be put off by at most this long.
  virtual int set_timer_slack_ns(unsigned long ns) = 0;
  /// Pins the calling thread.
  virtual int set_cpu(int cpu) = 0;

  /// RLIMIT_MEMLOCK, bytes.
  virtual ResourceLimit memory_limit() = 0;
  /// Raises the soft limit to the hard one.
  virtual int raise_memory_limit() = 0;
  /// RLIMIT_MEMLOCK does not bind this process (CAP_IPC_LOCK, and the kernel honours it: inside a
  /// user namespace the capability exists without effect).
  virtual bool may_lock_any_memory() = 0;
  /// mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT).
  virtual int lock_memory() = 0;

  /// Opens what keep_awake() needs, /dev/cpu_dma_latency. Changes nothing by itself.
  virtual int open_idle_latency() = 0;
  /// Idle processors of this host poll instead of sleeping, until keep_awake(false) or the end of
  /// this process. Without effect unless open_idle_latency() answered 0. Wakes every processor:
  /// any thread but the loop's.
  virtual void keep_awake(bool awake) noexcept = 0;

  /// Touches the pages of the calling thread's stack that a tick may need.
  virtual void touch_stack() = 0;

 protected:
  RealtimeHost() = default;
};

/// Linux itself.
[[nodiscard]] RealtimeHost& real_host();

}  // namespace haptic::server
