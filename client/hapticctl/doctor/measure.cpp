#include "doctor/measure.hpp"

#include <fcntl.h>
#include <grp.h>
#include <pthread.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <sstream>
#include <thread>

#include "doctor/checks.hpp"

namespace haptic::ctl {
namespace {

constexpr int kPriority = 80;  // hapticd's default

// Bits of <linux/capability.h>.
constexpr int kIpcLock = 14, kSysNice = 23;

/// Deadlines as in hapticd's loop: a deadline that has passed is skipped, not caught up.
Jitter run_loop(double seconds, double period_s) {
  using Monotonic = std::chrono::steady_clock;
  const auto period =
      std::chrono::duration_cast<Monotonic::duration>(std::chrono::duration<double>(period_s));
  const auto ticks = static_cast<std::int64_t>(std::max(0.0, seconds / period_s));
  std::vector<double> lateness;
  lateness.reserve(static_cast<std::size_t>(ticks) + 1);
  std::uint64_t skipped = 0;
  const Monotonic::time_point start = Monotonic::now(), end = start + ticks * period;
  for (Monotonic::time_point deadline = start + period; deadline <= end;) {
    // Absolute, as the loop sleeps: std::this_thread::sleep_until() computes a relative time first.
    const std::int64_t at = deadline.time_since_epoch().count();
    const timespec wake{at / 1'000'000'000, at % 1'000'000'000};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr) != 0) continue;
    const Monotonic::duration late = Monotonic::now() - deadline;
    lateness.push_back(std::chrono::duration<double, std::micro>(late).count());
    const auto passed = late / period;
    skipped += static_cast<std::uint64_t>(passed);
    deadline += (passed + 1) * period;
  }
  return summarise(std::move(lateness), skipped);
}

bool has_capability(int bit) {
  std::istringstream lines(HostFiles().text("/proc/self/status").value_or(""));
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("CapEff:", 0) != 0) continue;
    return (std::stoull(line.substr(7), nullptr, 16) >> bit & 1U) != 0;
  }
  return false;
}

}  // namespace

Jitter summarise(std::vector<double> lateness_us, std::uint64_t skipped) {
  Jitter jitter;
  jitter.skipped = skipped;
  jitter.ticks = lateness_us.size() + skipped;
  if (lateness_us.empty()) return jitter;
  std::sort(lateness_us.begin(), lateness_us.end());
  const auto rank = [&](double share) {
    const auto n = static_cast<double>(lateness_us.size());
    return lateness_us[static_cast<std::size_t>(std::max(0.0, std::ceil(share * n) - 1.0))];
  };
  jitter.p50_us = rank(0.50);
  jitter.p99_us = rank(0.99);
  jitter.max_us = lateness_us.back();
  return jitter;
}

HostAnswers ask_host(double seconds, double period_s) {
  HostAnswers answers;
  rlimit limit{};
  if (::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    answers.memlock = limit.rlim_cur;
  }
  answers.sys_nice = has_capability(kSysNice);
  answers.ipc_lock = has_capability(kIpcLock);
  for (const std::string& port : serial_ports(HostFiles())) {
    struct stat status {};
    if (::euidaccess(port.c_str(), R_OK | W_OK) == 0 || ::stat(port.c_str(), &status) != 0)
      continue;
    const group* const may = ::getgrgid(status.st_gid);
    answers.closed_ports[port] = may != nullptr ? may->gr_name : std::to_string(status.st_gid);
  }
  // Does what hapticd does while a device is controlled: idle processors stay awake until it is
  // closed.
  const int idle = ::open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC);
  const std::int32_t longest_us = 0;
  answers.idle_error = idle < 0 || ::write(idle, &longest_us, sizeof longest_us) < 0 ? errno : 0;
  std::thread loop([&] {
    static_cast<void>(::prctl(PR_SET_TIMERSLACK, 1UL));
    sched_param parameters{};
    parameters.sched_priority = kPriority;
    answers.fifo_error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters);
    answers.jitter = run_loop(seconds, period_s);
  });
  loop.join();
  if (idle >= 0) ::close(idle);
  return answers;
}

}  // namespace haptic::ctl
