#include "doctor/checks.hpp"

#include <cstring>

namespace haptic::ctl {
namespace {

/// loop_late_fault of hapticd with real-time scheduling, us (server/README.md#real-time-set-up).
constexpr double kLateFaultUs = 8000.0;
constexpr double kGoodP99Us = 100.0;   // a tenth of the period
constexpr double kGoodMaxUs = 1000.0;  // no deadline is passed over
/// The package hapticd makes the group and its limits.
constexpr const char* kJoinGroup =
    "usermod -aG haptic USER, then log in again (the group of the package hapticd; without it: "
    "docker/packaging/debian/limits.conf)";

std::string error_text(int error) {
  const char* short_name = strerrorname_np(error);
  return std::string(short_name != nullptr ? short_name : "error") + ": " + strerrordesc_np(error);
}

}  // namespace

Finding check_kernel(const HostFiles& host) {
  const std::string release = host.text("/proc/sys/kernel/osrelease").value_or("unknown");
  if (host.number("/sys/kernel/realtime") == 1) {
    return {"kernel", Health::kGood, release + ", PREEMPT_RT", ""};
  }
  return {"kernel", Health::kImpaired, release + ", not PREEMPT_RT",
          "a PREEMPT_RT kernel bounds the largest lateness (Debian: linux-image-rt-amd64)"};
}

Finding check_realtime(const HostFiles& host, const HostAnswers& answers) {
  Finding finding{"real-time", Health::kGood, "SCHED_FIFO 80 granted", ""};
  if (answers.fifo_error != 0) {
    finding.health = Health::kImpaired;
    finding.found = "SCHED_FIFO refused (" + error_text(answers.fifo_error) + ")";
    if (without_realtime_budget(host)) {
      finding.found += ": the control group's cpu.rt_runtime_us is 0";
      finding.advice =
          "give the group a real-time budget (docker run --cpu-rt-runtime=950000), or run hapticd "
          "outside the group";
    } else if (answers.sys_nice) {
      finding.found += ", although CAP_SYS_NICE is held: the container gives no real-time budget";
      finding.advice = "run hapticd outside the container, or allow it real-time scheduling";
    } else {
      finding.advice = std::string(kJoinGroup) + "; in a container --cap-add=SYS_NICE";
    }
    return finding;
  }
  const auto runtime = host.number("/proc/sys/kernel/sched_rt_runtime_us");
  const auto period = host.number("/proc/sys/kernel/sched_rt_period_us");
  if (!runtime || !period || *runtime < 0 || *period <= 0) return finding;
  const double share = static_cast<double>(*runtime) / static_cast<double>(*period);
  finding.found +=
      format("; all real-time threads together may run %.0f %% of the time", 1e2 * share);
  if (share >= 0.5) return finding;
  finding.health = Health::kImpaired;
  finding.advice = "sysctl kernel.sched_rt_runtime_us=950000";
  return finding;
}

Finding check_memory(const HostAnswers& answers) {
  if (!answers.memlock) return {"memory", Health::kGood, "may be locked without limit", ""};
  if (answers.ipc_lock) {
    return {"memory", Health::kGood, "may be locked (CAP_IPC_LOCK)", ""};
  }
  return {"memory", Health::kImpaired,
          "RLIMIT_MEMLOCK is " + std::to_string(*answers.memlock / 1024) +
              " KB: a page fault may delay a tick",
          std::string(kJoinGroup) + "; in a container --ulimit memlock=-1"};
}

Finding check_governor(const HostFiles& host) {
  std::string others;
  int known = 0;
  for (const std::string& cpu : host.entries("/sys/devices/system/cpu", "cpu")) {
    const auto governor = host.text(cpu + "/cpufreq/scaling_governor");
    if (!governor) continue;
    ++known;
    if (*governor == "performance") continue;
    others +=
        (others.empty() ? "" : ", ") + cpu.substr(cpu.find_last_of('/') + 1) + " " + *governor;
  }
  if (known == 0) return {"governor", Health::kGood, "this host shows no frequency scaling", ""};
  if (others.empty()) return {"governor", Health::kGood, "performance", ""};
  return {"governor", Health::kImpaired, others + ": wake-ups wait for the clock to rise",
          "cpupower frequency-set -g performance"};
}

Finding check_jitter(const Jitter& jitter, double period_s) {
  Finding finding{
      "jitter", Health::kGood,
      format("over %.1f s: p50 %.0f us, p99 %.0f us, max %.0f us, %.0f deadlines skipped",
             static_cast<double>(jitter.ticks) * period_s, jitter.p50_us, jitter.p99_us,
             jitter.max_us, static_cast<double>(jitter.skipped)),
      ""};
  if (jitter.ticks == 0) {
    return {"jitter", Health::kBad, "was not measured", "give --seconds"};
  }
  if (jitter.max_us > kLateFaultUs) {
    finding.health = Health::kBad;
    finding.advice =
        "a wake-up more than 8 ms late is a fault: find what else runs here, and give the loop a "
        "CPU of its own (isolcpus=, loop.cpu)";
  } else if (jitter.p99_us > kGoodP99Us || jitter.max_us > kGoodMaxUs) {
    finding.health = Health::kImpaired;
    finding.advice =
        "real-time scheduling, the performance governor and a CPU of its own (loop.cpu)";
  }
  return finding;
}

}  // namespace haptic::ctl
