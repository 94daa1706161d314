#include "server/owner/loop/realtime_host.hpp"

#include <fcntl.h>
#include <linux/capability.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <fstream>

#include "server/base/descriptor.hpp"

namespace haptic::server {
namespace {

/// A tick of the largest device, gRPC not included: its records and matrices are some 60 KB.
constexpr std::size_t kStackToTouch = 256 * 1024;

ResourceLimit limit_of(__rlimit_resource resource) {
  rlimit got{};
  if (getrlimit(resource, &got) != 0) return {0, 0};
  ResourceLimit limit;
  if (got.rlim_cur != RLIM_INFINITY) limit.soft = got.rlim_cur;
  if (got.rlim_max != RLIM_INFINITY) limit.hard = got.rlim_max;
  return limit;
}

bool has_capability(int capability) {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> data{};
  if (syscall(SYS_capget, &header, data.data()) != 0) return false;
  const auto word = static_cast<std::size_t>(capability) / 32;
  return ((data[word].effective >> (capability % 32)) & 1u) != 0;
}

std::optional<double> number_in(const char* path) {
  std::ifstream file(path);
  double value = 0.0;
  if (!(file >> value)) return std::nullopt;
  return value;
}

/// Errno of a call that answers -1 on failure.
int error_of(long result) {
  return result == -1 ? errno : 0;
}

/// The kernel forgets what was asked for when the file is closed.
struct IdleLatency {
  Descriptor file{::open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC)};
  int error{file ? 0 : errno};
};

IdleLatency& idle_latency() {
  static IdleLatency opened;  // by the first who asks, for the whole process
  return opened;
}

class LinuxHost final : public RealtimeHost {
 public:
  int set_fifo(int priority) override {
    sched_param parameters{};
    parameters.sched_priority = priority;
    return error_of(sched_setscheduler(0, SCHED_FIFO, &parameters));
  }
  ResourceLimit priority_limit() override { return limit_of(RLIMIT_RTPRIO); }
  bool may_set_any_priority() override { return has_capability(CAP_SYS_NICE); }
  std::optional<double> realtime_share() override {
    const auto runtime = number_in("/proc/sys/kernel/sched_rt_runtime_us");
    const auto period = number_in("/proc/sys/kernel/sched_rt_period_us");
    if (!runtime || !period || *runtime < 0.0 || *period <= 0.0) return std::nullopt;
    return *runtime / *period;
  }

  int set_timer_slack_ns(unsigned long ns) override {
    return error_of(prctl(PR_SET_TIMERSLACK, ns, 0, 0, 0));
  }
  int set_cpu(int cpu) override {
    if (cpu < 0 || cpu >= CPU_SETSIZE) return EINVAL;
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<unsigned>(cpu), &set);
    return error_of(sched_setaffinity(0, sizeof set, &set));
  }

  ResourceLimit memory_limit() override { return limit_of(RLIMIT_MEMLOCK); }
  int raise_memory_limit() override {
    rlimit limit{};
    if (getrlimit(RLIMIT_MEMLOCK, &limit) != 0) return errno;
    limit.rlim_cur = limit.rlim_max;
    return error_of(setrlimit(RLIMIT_MEMLOCK, &limit));
  }
  /// Asks the kernel rather than the capability set: under a limit of 0 only those whom the limit
  /// does not bind can lock a page.
  bool may_lock_any_memory() override {
    if (!has_capability(CAP_IPC_LOCK)) return false;
    rlimit before{};
    if (getrlimit(RLIMIT_MEMLOCK, &before) != 0) return false;
    rlimit none = before;
    none.rlim_cur = 0;
    if (setrlimit(RLIMIT_MEMLOCK, &none) != 0) return false;
    alignas(4096) static char page[4096];
    const bool locked = mlock(page, sizeof page) == 0;
    if (locked) munlock(page, sizeof page);
    setrlimit(RLIMIT_MEMLOCK, &before);
    return locked;
  }
  int lock_memory() override { return error_of(mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT)); }

  int open_idle_latency() override { return idle_latency().error; }
  void keep_awake(bool awake) noexcept override {
    // The longest wake-up that the kernel may choose for an idle processor, us; -1: its default.
    const std::int32_t longest_us = awake ? 0 : -1;
    static_cast<void>(!::write(idle_latency().file.get(), &longest_us, sizeof longest_us));
  }

  [[gnu::noinline]] void touch_stack() override {
    char pages[kStackToTouch];
    // One write per page is enough; the compiler must not see that they are not read.
    for (std::size_t i = 0; i < kStackToTouch; i += 1024) {
      pages[i] = 0;
      asm volatile("" : : "r"(pages + i) : "memory");
    }
  }
};

}  // namespace

RealtimeHost& real_host() {
  static LinuxHost host;
  return host;
}

}  // namespace haptic::server
