#include <sstream>

#include "doctor/checks.hpp"

namespace haptic::ctl {
namespace {

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

/// `path` and every folder above it: the limits of all of them apply.
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

}  // namespace

bool without_realtime_budget(const HostFiles& host) {
  const std::string path = cgroup_paths(host).cpu;
  return host.number("/sys/fs/cgroup/cpu" + path + "/cpu.rt_runtime_us") == 0;
}

Finding check_cgroup(const HostFiles& host) {
  const auto budget = cpu_budget(host);
  if (!budget) return {"cgroup", Health::kGood, "no CPU limit", ""};
  const double share = budget->runtime_us / budget->period_us;
  Finding finding{"cgroup", Health::kGood, format("limited to %.2f CPUs", share), ""};
  // Loop, telemetry and gRPC together stay below one CPU at 1 kHz.
  if (share >= 1.0) return finding;
  finding.health = Health::kBad;
  finding.found += format(": once it is used up, hapticd stands still for up to %.0f ms",
                          1e-3 * (budget->period_us - budget->runtime_us));
  finding.advice = "raise " + budget->file + " to at least one CPU (docker run --cpus)";
  return finding;
}

}  // namespace haptic::ctl
