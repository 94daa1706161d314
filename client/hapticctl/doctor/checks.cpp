#include "doctor/checks.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <sstream>

namespace haptic::ctl {
namespace {

/// loop_late_fault of hapticd on a real-time host, us (server/README.md): beyond it a wake-up is a
/// fault.
constexpr double kLateFaultUs = 8000.0;
constexpr double kGoodP99Us = 100.0;   // a tenth of the period
constexpr double kGoodMaxUs = 1000.0;  // no deadline is passed over
constexpr const char* kLimitsFile = "/etc/security/limits.d/haptic.conf";

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  char text[160];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

std::string error_text(int error) {
  const char* short_name = strerrorname_np(error);
  return std::string(short_name != nullptr ? short_name : "error") + ": " + strerrordesc_np(error);
}

struct CgroupPaths {
  std::string unified{};  ///< v2
  std::string cpu{};      ///< v1, of the controller cpu
};

/// /proc/self/cgroup: "0::/path" of v2, "5:cpu,cpuacct:/path" of v1.
CgroupPaths cgroup_paths(const HostFiles& host) {
  CgroupPaths paths;
  std::istringstream lines(host.text("/proc/self/cgroup").value_or(""));
  for (std::string line; std::getline(lines, line);) {
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    if (controllers == ",,") paths.unified = line.substr(second + 1);
    if (controllers.find(",cpu,") != std::string::npos) paths.cpu = line.substr(second + 1);
  }
  return paths;
}

/// `path` and every folder above it: a limit of any of them binds.
std::vector<std::string> with_parents(std::string path) {
  std::vector<std::string> all;
  while (!path.empty() && path != "/") {
    all.push_back(path);
    path.erase(path.find_last_of('/'));
  }
  all.emplace_back("");
  return all;
}

struct Budget {
  double runtime_us{0.0}, period_us{0.0};
  std::string file{};
};

/// "50000 100000", or "max 100000" for no limit.
std::optional<Budget> read_cpu_max(const HostFiles& host, const std::string& file) {
  Budget budget;
  budget.file = file;
  if (std::sscanf(host.text(file).value_or("").c_str(), "%lf %lf", &budget.runtime_us,
                  &budget.period_us) != 2) {
    return std::nullopt;
  }
  return budget;
}

/// The tightest budget of this process, in CPUs.
std::optional<Budget> cpu_budget(const HostFiles& host) {
  std::optional<Budget> tightest;
  const auto consider = [&](const std::optional<Budget>& budget) {
    if (!budget || budget->period_us <= 0.0 || budget->runtime_us <= 0.0) return;
    const double share = budget->runtime_us / budget->period_us;
    if (!tightest || share < tightest->runtime_us / tightest->period_us) tightest = budget;
  };
  const CgroupPaths paths = cgroup_paths(host);
  for (const std::string& path : with_parents(paths.unified)) {
    consider(read_cpu_max(host, "/sys/fs/cgroup" + path + "/cpu.max"));
  }
  for (const std::string& path : with_parents(paths.cpu)) {
    const std::string folder = "/sys/fs/cgroup/cpu" + path;
    const auto quota = host.number(folder + "/cpu.cfs_quota_us");
    const auto period = host.number(folder + "/cpu.cfs_period_us");
    if (!quota || !period) continue;
    consider(Budget{static_cast<double>(*quota), static_cast<double>(*period),
                    folder + "/cpu.cfs_quota_us"});
  }
  return tightest;
}

/// v1 kernels with RT_GROUP_SCHED give every group a real-time budget of its own: 0 by default.
bool without_realtime_budget(const HostFiles& host) {
  const std::string path = cgroup_paths(host).cpu;
  return host.number("/sys/fs/cgroup/cpu" + path + "/cpu.rt_runtime_us") == 0;
}

std::string group_name(const HostFiles& host, gid_t group) {
  std::istringstream lines(host.text("/etc/group").value_or(""));
  for (std::string line; std::getline(lines, line);) {
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    if (std::to_string(group) == line.substr(second + 1, line.find(':', second + 1) - second - 1)) {
      return line.substr(0, first);
    }
  }
  return std::to_string(group);
}

bool may_use(const HostFiles::Ownership& port, const HostAnswers& answers) {
  if (answers.user == 0) return true;
  const auto allows = [&](mode_t bits) { return (port.mode & bits) == bits; };
  if (port.user == answers.user) return allows(S_IRUSR | S_IWUSR);
  const bool in_group =
      std::find(answers.groups.begin(), answers.groups.end(), port.group) != answers.groups.end();
  return allows(in_group ? S_IRGRP | S_IWGRP : S_IROTH | S_IWOTH);
}

std::string latency_file(const std::string& port) {
  return "/sys/bus/usb-serial/devices/" + port.substr(port.find_last_of('/') + 1) +
         "/latency_timer";
}

Finding check_port(const HostFiles& host, const HostAnswers& answers, const std::string& port) {
  Finding finding{"serial", Health::kGood, port + ": may be opened", ""};
  const auto ownership = host.ownership(port);
  if (!ownership) return {"serial", Health::kBad, port + ": is there, but cannot be looked at", ""};
  if (!may_use(*ownership, answers)) {
    finding.health = Health::kBad;
    finding.found = port + ": may not be opened by this user";
    finding.advice =
        "usermod -aG " + group_name(host, ownership->group) + " USER, then log in anew";
    return finding;
  }
  const auto timer = host.number(latency_file(port));
  if (!timer) return finding;
  finding.found += ", latency timer " + std::to_string(*timer) + " ms";
  if (*timer <= 1) return finding;
  finding.health = Health::kImpaired;
  finding.advice = "echo 1 > " + latency_file(port) + " (samples wait for it)";
  return finding;
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
          "give the group a real-time budget (docker run --cpu-rt-runtime=950000), or "
          "run hapticd outside of it";
    } else if (answers.sys_nice) {
      finding.found += ", although CAP_SYS_NICE is held: the container gives no real-time budget";
      finding.advice = "run hapticd outside of the container, or allow it real-time scheduling";
    } else {
      finding.advice = "echo '@haptic - rtprio 95' >> " + std::string(kLimitsFile) +
                       " for members of a group haptic; in a container --cap-add=SYS_NICE";
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
          "echo '@haptic - memlock unlimited' >> " + std::string(kLimitsFile) +
              "; in a container --ulimit memlock=-1"};
}

Finding check_cgroup(const HostFiles& host) {
  const auto budget = cpu_budget(host);
  if (!budget) return {"cgroup", Health::kGood, "no CPU limit", ""};
  const double share = budget->runtime_us / budget->period_us;
  Finding finding{"cgroup", Health::kGood, format("limited to %.2f CPUs", share), ""};
  // Loop, telemetry and gRPC together stay below one CPU at 1 kHz.
  if (share >= 1.0) return finding;
  finding.health = Health::kBad;
  finding.found += format(": once it is used up everything stands still for up to %.0f ms",
                          1e-3 * (budget->period_us - budget->runtime_us));
  finding.advice = "raise " + budget->file + " to at least one CPU (docker run --cpus)";
  return finding;
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
  if (known == 0) return {"governor", Health::kGood, "no frequency scaling is to be seen here", ""};
  if (others.empty()) return {"governor", Health::kGood, "performance", ""};
  return {"governor", Health::kImpaired, others + ": wake-ups wait for the clock to rise",
          "cpupower frequency-set -g performance"};
}

Finding check_jitter(const Jitter& jitter, double period_s) {
  Finding finding{
      "jitter", Health::kGood,
      format("over %.1f s: p50 %.0f us, p99 %.0f us, max %.0f us, %.0f deadlines passed "
             "over",
             static_cast<double>(jitter.ticks) * period_s, jitter.p50_us, jitter.p99_us,
             jitter.max_us, static_cast<double>(jitter.skipped)),
      ""};
  if (jitter.ticks == 0) {
    return {"jitter", Health::kBad, "was not measured", "give --seconds"};
  }
  if (jitter.max_us > kLateFaultUs) {
    finding.health = Health::kBad;
    finding.advice =
        "a wake-up more than 8 ms late is a fault: find what else runs here, and give "
        "the loop a CPU of its own (isolcpus=, loop.cpu)";
  } else if (jitter.p99_us > kGoodP99Us || jitter.max_us > kGoodMaxUs) {
    finding.health = Health::kImpaired;
    finding.advice =
        "real-time scheduling, the performance governor and a CPU of its own (loop.cpu)";
  }
  return finding;
}

std::vector<Finding> check_serial(const HostFiles& host, const HostAnswers& answers) {
  std::vector<Finding> findings;
  for (const char* kind : {"ttyACM", "ttyUSB"}) {
    for (const std::string& port : host.entries("/dev", kind)) {
      findings.push_back(check_port(host, answers, port));
    }
  }
  if (findings.empty()) {
    findings.push_back({"serial", Health::kGood, "no USB serial port is plugged in", ""});
  }
  return findings;
}

double serial_latency(const HostFiles& host) {
  double longest = 0.0;
  for (const std::string& port : host.entries("/dev", "ttyUSB")) {
    longest =
        std::max(longest, 1e-3 * static_cast<double>(host.number(latency_file(port)).value_or(0)));
  }
  return longest;
}

}  // namespace haptic::ctl
