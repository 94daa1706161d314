#include "doctor/checks.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>
#include <sstream>

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

/// Text by printf's rules; up to 159 characters.
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

/// The path of /proc/self/cgroup's line "0::/path"; empty for the root.
std::string cgroup_path(const HostFiles& host) {
  std::istringstream lines(host.text("/proc/self/cgroup").value_or(""));
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("0::/", 0) == 0) return line.size() == 4 ? "" : line.substr(3);
  }
  return {};
}

std::string latency_file(const std::string& port) {
  return "/sys/bus/usb-serial/devices/" + port.substr(port.find_last_of('/') + 1) +
         "/latency_timer";
}

Finding check_port(const HostFiles& host, const HostAnswers& answers, const std::string& port) {
  if (const auto closed = answers.closed_ports.find(port); closed != answers.closed_ports.end()) {
    return {"serial", Health::kBad, port + ": may not be opened by this user",
            "usermod -aG " + closed->second + " USER, then log in again"};
  }
  const std::string found = port + ": may be opened";
  const auto timer = host.number(latency_file(port));
  if (!timer) return {"serial", Health::kGood, found, ""};
  const std::string timed = found + ", latency timer " + std::to_string(*timer) + " ms";
  if (*timer <= 1) return {"serial", Health::kGood, timed, ""};
  return {"serial", Health::kImpaired, timed,
          "echo 1 > " + latency_file(port) + " (it delays samples)"};
}

}  // namespace

std::vector<std::string> serial_ports(const HostFiles& host) {
  std::vector<std::string> all = host.entries("/dev", "ttyACM");
  for (std::string& port : host.entries("/dev", "ttyUSB")) all.push_back(std::move(port));
  return all;
}

Finding check_kernel(const HostFiles& host) {
  const std::string release = host.text("/proc/sys/kernel/osrelease").value_or("unknown");
  if (host.number("/sys/kernel/realtime") == 1) {
    return {"kernel", Health::kGood, release + ", PREEMPT_RT", ""};
  }
  return {"kernel", Health::kImpaired, release + ", not PREEMPT_RT",
          "a PREEMPT_RT kernel bounds the largest lateness (Debian: linux-image-rt-amd64)"};
}

Finding check_realtime(const HostAnswers& answers) {
  if (answers.fifo_error == 0) return {"real-time", Health::kGood, "SCHED_FIFO 80 granted", ""};
  const std::string refused = "SCHED_FIFO refused (" + error_text(answers.fifo_error) + ")";
  if (answers.sys_nice) {
    return {"real-time", Health::kImpaired,
            refused + ", although CAP_SYS_NICE is held: the container gives no real-time budget",
            "run hapticd outside the container, or allow it real-time scheduling"};
  }
  return {"real-time", Health::kImpaired, refused,
          std::string(kJoinGroup) + "; in a container --cap-add=SYS_NICE"};
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

Finding check_idle(const HostAnswers& answers) {
  if (answers.idle_error == 0) {
    return {"idle", Health::kGood, "idle processors may be kept awake", ""};
  }
  const bool absent = answers.idle_error == ENOENT;
  return {"idle", Health::kImpaired,
          "/dev/cpu_dma_latency refused (" + error_text(answers.idle_error) +
              "): idle processors sleep, and wake-ups are late",
          absent ? "in a container --device /dev/cpu_dma_latency, owned by a group of its user"
                 : "usermod -aG haptic USER, then log in again (the group of the package hapticd; "
                   "without it: docker/packaging/debian/60-haptic.rules)"};
}

Finding check_cgroup(const HostFiles& host) {
  std::string path = cgroup_path(host), file;
  double share = std::numeric_limits<double>::infinity(), standstill_ms = 0.0;
  for (;; path.erase(path.find_last_of('/'))) {  // the tightest limit of all parents counts
    const std::string its = "/sys/fs/cgroup" + path + "/cpu.max";
    double runtime_us = 0.0, period_us = 0.0;  // "50000 100000", or "max 100000" for no limit
    std::istringstream limit(host.text(its).value_or(""));
    if (limit >> runtime_us >> period_us && runtime_us < share * period_us) {
      share = runtime_us / period_us;
      standstill_ms = 1e-3 * (period_us - runtime_us);
      file = its;
    }
    if (path.empty()) break;
  }
  if (file.empty()) return {"cgroup", Health::kGood, "no CPU limit", ""};
  const std::string found = format("limited to %.2f CPUs", share);
  // Loop, telemetry and gRPC together stay below one CPU at 1 kHz.
  if (share >= 1.0) return {"cgroup", Health::kGood, found, ""};
  return {
      "cgroup", Health::kBad,
      found + format(": once it is used up, hapticd stands still for up to %.0f ms", standstill_ms),
      "raise " + file + " to at least one CPU (docker run --cpus)"};
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

std::vector<Finding> check_serial(const HostFiles& host, const HostAnswers& answers) {
  std::vector<Finding> findings;
  for (const std::string& port : serial_ports(host)) {
    findings.push_back(check_port(host, answers, port));
  }
  if (findings.empty()) {
    findings.push_back({"serial", Health::kGood, "no USB serial port is plugged in", ""});
  }
  return findings;
}

double serial_latency(const HostFiles& host) {
  long long longest_ms = 0;
  for (const std::string& port : serial_ports(host)) {
    longest_ms = std::max(longest_ms, host.number(latency_file(port)).value_or(0));
  }
  return 1e-3 * static_cast<double>(longest_ms);
}

}  // namespace haptic::ctl
