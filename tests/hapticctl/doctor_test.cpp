#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <nlohmann/json.hpp>

#include "doctor/checks.hpp"
#include "doctor/examine.hpp"
#include "doctor/measure.hpp"

namespace haptic::ctl {
namespace {

namespace fs = std::filesystem;

/// A host's files below a folder of its own.
class FakeHost {
 public:
  FakeHost()
      : root_(fs::temp_directory_path() /
              ("haptic-doctor-" + std::to_string(::getpid()) + "-" + std::to_string(++count_))) {
    fs::create_directories(root_);
  }
  ~FakeHost() { fs::remove_all(root_); }
  FakeHost(const FakeHost&) = delete;
  FakeHost& operator=(const FakeHost&) = delete;

  FakeHost& file(const std::string& path, const std::string& text) {
    const fs::path full = root_ / fs::path(path).relative_path();
    fs::create_directories(full.parent_path());
    std::ofstream(full) << text;
    return *this;
  }
  FakeHost& port(const std::string& path, mode_t mode) {
    file(path, "");
    ::chmod((root_ / fs::path(path).relative_path()).c_str(), mode);
    return *this;
  }
  [[nodiscard]] HostFiles files() const { return HostFiles(root_); }

 private:
  static inline int count_ = 0;
  fs::path root_;
};

/// A host where everything is as it should be.
void make_good(FakeHost& host) {
  host.file("/proc/sys/kernel/osrelease", "6.1.0-rt-amd64\n")
      .file("/sys/kernel/realtime", "1\n")
      .file("/proc/sys/kernel/sched_rt_runtime_us", "950000\n")
      .file("/proc/sys/kernel/sched_rt_period_us", "1000000\n")
      .file("/proc/self/cgroup", "0::/user.slice\n")
      .file("/sys/fs/cgroup/user.slice/cpu.max", "max 100000\n")
      .file("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n");
}

HostAnswers good_answers() {
  HostAnswers answers;
  answers.user = 1000;
  answers.jitter = {10'000, 0, 20.0, 50.0, 120.0};
  return answers;
}

const Finding& finding(const Report& report, const std::string& what) {
  for (const Finding& f : report.findings) {
    if (f.what == what) return f;
  }
  throw std::runtime_error("no finding " + what);
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Doctor, AHostWithNothingWrongIsRealTime) {
  FakeHost host;
  make_good(host);
  const Report report = examine(host.files(), good_answers(), {});
  EXPECT_EQ(report.grade, "real-time");
  for (const Finding& f : report.findings) {
    EXPECT_EQ(f.health, Health::kGood) << f.what << ": " << f.found;
    EXPECT_TRUE(f.advice.empty()) << f.what;
  }
}

TEST(Doctor, AnEmptyHostIsDegradedNotAGuess) {
  FakeHost host;
  const Report report = examine(host.files(), good_answers(), {});
  EXPECT_EQ(report.grade, "degraded");
  EXPECT_TRUE(has(finding(report, "kernel").found, "unknown"));
}

TEST(Doctor, SaysWhyRealTimeWasRefused) {
  FakeHost host;
  make_good(host);
  HostAnswers answers = good_answers();
  answers.fifo_error = EPERM;
  Finding f = check_realtime(host.files(), answers);
  EXPECT_EQ(f.health, Health::kImpaired);
  EXPECT_TRUE(has(f.found, "EPERM")) << f.found;
  EXPECT_TRUE(has(f.advice, "usermod -aG haptic")) << f.advice;

  answers.sys_nice = true;
  f = check_realtime(host.files(), answers);
  EXPECT_TRUE(has(f.found, "CAP_SYS_NICE is held")) << f.found;

  host.file("/proc/self/cgroup", "5:cpu,cpuacct:/docker/x\n0::/\n")
      .file("/sys/fs/cgroup/cpu/docker/x/cpu.rt_runtime_us", "0\n");
  f = check_realtime(host.files(), answers);
  EXPECT_TRUE(has(f.found, "cpu.rt_runtime_us is 0")) << f.found;
  EXPECT_TRUE(has(f.advice, "--cpu-rt-runtime")) << f.advice;
}

TEST(Doctor, AScantShareForAllRealTimeThreadsIsNamed) {
  FakeHost host;
  make_good(host);
  host.file("/proc/sys/kernel/sched_rt_runtime_us", "200000\n");
  const Finding f = check_realtime(host.files(), good_answers());
  EXPECT_EQ(f.health, Health::kImpaired);
  EXPECT_TRUE(has(f.found, "20 %")) << f.found;
  host.file("/proc/sys/kernel/sched_rt_runtime_us", "-1\n");
  EXPECT_EQ(check_realtime(host.files(), good_answers()).health, Health::kGood);
}

TEST(Doctor, MemoryNeedsNoLimitOrTheCapability) {
  HostAnswers answers = good_answers();
  answers.memlock = 8 * 1024 * 1024;
  EXPECT_EQ(check_memory(answers).health, Health::kImpaired);
  EXPECT_TRUE(has(check_memory(answers).found, "8192 KB"));
  answers.ipc_lock = true;
  EXPECT_EQ(check_memory(answers).health, Health::kGood);
}

struct CgroupCase {
  const char* what;
  const char* cgroup;
  std::vector<std::pair<const char*, const char*>> files;
  Health health;
  const char* found;
};

TEST(Doctor, TheTightestCpuBudgetOfAllParentsCounts) {
  const CgroupCase cases[] = {
      {"v2, none",
       "0::/a\n",
       {{"/sys/fs/cgroup/a/cpu.max", "max 100000"}},
       Health::kGood,
       "no CPU limit"},
      {"v2, plenty",
       "0::/a\n",
       {{"/sys/fs/cgroup/a/cpu.max", "400000 100000"}},
       Health::kGood,
       "4.00 CPUs"},
      {"v2, half a CPU, in a parent",
       "0::/a/b\n",
       {{"/sys/fs/cgroup/a/b/cpu.max", "200000 100000"},
        {"/sys/fs/cgroup/a/cpu.max", "50000 100000"}},
       Health::kBad,
       "stands still for up to 50 ms"},
      {"v1, none",
       "5:cpu,cpuacct:/d\n",
       {{"/sys/fs/cgroup/cpu/d/cpu.cfs_quota_us", "-1"},
        {"/sys/fs/cgroup/cpu/d/cpu.cfs_period_us", "100000"}},
       Health::kGood,
       "no CPU limit"},
      {"v1, a fifth",
       "5:cpu,cpuacct:/d\n",
       {{"/sys/fs/cgroup/cpu/d/cpu.cfs_quota_us", "20000"},
        {"/sys/fs/cgroup/cpu/d/cpu.cfs_period_us", "100000"}},
       Health::kBad,
       "0.20 CPUs"},
  };
  for (const CgroupCase& c : cases) {
    FakeHost host;
    host.file("/proc/self/cgroup", c.cgroup);
    for (const auto& [path, text] : c.files) host.file(path, text);
    const Finding f = check_cgroup(host.files());
    EXPECT_EQ(f.health, c.health) << c.what;
    EXPECT_TRUE(has(f.found, c.found)) << c.what << ": " << f.found;
  }
}

TEST(Doctor, EveryCpuWithAnotherGovernorIsNamed) {
  FakeHost host;
  host.file("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n")
      .file("/sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave\n");
  const Finding f = check_governor(host.files());
  EXPECT_EQ(f.health, Health::kImpaired);
  EXPECT_TRUE(has(f.found, "cpu1 powersave")) << f.found;
  EXPECT_FALSE(has(f.found, "cpu0"));
}

TEST(Doctor, APortThatMayNotBeOpenedNamesTheGroup) {
  FakeHost host;
  host.port("/dev/ttyACM0", 0660);
  const auto owner = host.files().ownership("/dev/ttyACM0");
  ASSERT_TRUE(owner);
  host.file("/etc/group",
            "root:x:99998:\ndialout:x:" + std::to_string(owner->group) + ":someone\n");
  HostAnswers answers = good_answers();
  answers.user = owner->user + 1;
  Finding f = check_serial(host.files(), answers).at(0);
  EXPECT_EQ(f.health, Health::kBad);
  EXPECT_TRUE(has(f.advice, "usermod -aG dialout")) << f.advice;
  answers.groups = {owner->group};
  f = check_serial(host.files(), answers).at(0);
  EXPECT_EQ(f.health, Health::kGood) << f.found;
}

TEST(Doctor, AnFtdiAdapterThatSitsOnItsBytesIsNamedWithTheFileToWrite) {
  FakeHost host;
  host.port("/dev/ttyUSB0", 0666)
      .file("/sys/bus/usb-serial/devices/ttyUSB0/latency_timer", "16\n")
      .port("/dev/ttyUSB1", 0666)
      .file("/sys/bus/usb-serial/devices/ttyUSB1/latency_timer", "1\n");
  const auto findings = check_serial(host.files(), good_answers());
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].health, Health::kImpaired);
  EXPECT_TRUE(has(findings[0].advice, "ttyUSB0/latency_timer")) << findings[0].advice;
  EXPECT_EQ(findings[1].health, Health::kGood);
  EXPECT_DOUBLE_EQ(serial_latency(host.files()), 0.016);
}

TEST(Doctor, JitterIsJudgedAgainstThePeriodAndTheFault) {
  EXPECT_EQ(check_jitter({10'000, 0, 10.0, 60.0, 300.0}, 1e-3).health, Health::kGood);
  EXPECT_EQ(check_jitter({10'000, 0, 40.0, 140.0, 300.0}, 1e-3).health, Health::kImpaired);
  EXPECT_EQ(check_jitter({10'000, 3, 10.0, 60.0, 4000.0}, 1e-3).health, Health::kImpaired);
  EXPECT_EQ(check_jitter({10'000, 9, 10.0, 60.0, 9000.0}, 1e-3).health, Health::kBad);
  EXPECT_EQ(check_jitter({}, 1e-3).health, Health::kBad);
}

TEST(Doctor, TheWorstFindingIsTheGrade) {
  FakeHost host;
  make_good(host);
  HostAnswers answers = good_answers();
  answers.jitter.p99_us = 500.0;
  EXPECT_EQ(examine(host.files(), answers, {}).grade, "degraded");
  host.file("/sys/fs/cgroup/user.slice/cpu.max", "10000 100000\n");
  EXPECT_EQ(examine(host.files(), answers, {}).grade, "unfit");
}

TEST(Doctor, TheStiffnessCapIsThatOfMethod51) {
  FakeHost host;
  make_good(host);
  HostAnswers answers = good_answers();
  answers.jitter = {10'000, 0, 0.0, 0.0, 0.0};
  // b = 1 N s/m at 1 ms: Z_q,max = 2 b / T = 2000 N/m.
  Report report = examine(host.files(), answers, {1e-3, 1.0, 0.0});
  EXPECT_NEAR(report.cap.passive, 2000.0, 1e-9);
  EXPECT_NEAR(report.cap.stable, 2000.0, 1e-9);
  // Rendered damping takes from passivity and gives to stability.
  report = examine(host.files(), answers, {1e-3, 2.0, 0.5});
  EXPECT_NEAR(report.cap.passive, 3000.0, 1e-9);
  EXPECT_NEAR(report.cap.stable, 5000.0, 1e-9);
  // A wake-up 1 ms late holds a force for 2 ms; 3 ms of delay: K < b / 3.5 ms.
  answers.jitter = {10'000, 0, 0.0, 3000.0, 1000.0};
  report = examine(host.files(), answers, {1e-3, 1.0, 0.0});
  EXPECT_NEAR(report.cap.passive, 1000.0, 1e-9);
  EXPECT_NEAR(report.cap.stable, 1.0 / 3.5e-3, 1e-9);
  // More rendered damping than the device has leaves nothing.
  report = examine(host.files(), answers, {1e-3, 1.0, 1.5});
  EXPECT_EQ(report.cap.passive, 0.0);
}

TEST(Doctor, ASlowAdapterLowersTheStableCap) {
  FakeHost host;
  make_good(host);
  host.port("/dev/ttyUSB0", 0666).file("/sys/bus/usb-serial/devices/ttyUSB0/latency_timer", "16\n");
  HostAnswers answers = good_answers();
  answers.jitter = {10'000, 0, 0.0, 0.0, 0.0};
  const Report report = examine(host.files(), answers, {1e-3, 1.0, 0.0});
  EXPECT_NEAR(report.cap.stable, 1.0 / 16.5e-3, 1e-9);
}

TEST(Doctor, PercentilesAreThoseOfTheRank) {
  std::vector<double> lateness;
  for (int i = 100; i >= 1; --i) lateness.push_back(i);
  const Jitter jitter = summarise(lateness, 7);
  EXPECT_EQ(jitter.p50_us, 50.0);
  EXPECT_EQ(jitter.p99_us, 99.0);
  EXPECT_EQ(jitter.max_us, 100.0);
  EXPECT_EQ(jitter.ticks, 107u);
  EXPECT_EQ(summarise({}, 0).ticks, 0u);
}

TEST(Doctor, JsonHoldsWhatTheTextHolds) {
  FakeHost host;
  make_good(host);
  HostAnswers answers = good_answers();
  answers.memlock = 1024;
  const StiffnessQuestion question{1e-3, 1.0, 0.25};
  const Report report = examine(host.files(), answers, question);
  const auto json = nlohmann::json::parse(to_json(report, question));
  EXPECT_EQ(json["grade"], "degraded");
  EXPECT_EQ(json["findings"].size(), report.findings.size());
  EXPECT_EQ(json["stiffness_cap"]["rendered_damping_n_s_per_m"], 0.25);
  EXPECT_NEAR(json["stiffness_cap"]["passive_n_per_m"], report.cap.passive, 1e-9);
  const std::string text = to_text(report, question);
  for (const Finding& f : report.findings) {
    EXPECT_TRUE(has(text, f.found)) << text;
    EXPECT_TRUE(has(text, f.advice)) << text;
  }
  EXPECT_TRUE(has(text, "grade: degraded")) << text;
}

TEST(Doctor, MeasuresThisVeryHost) {
  const HostAnswers answers = ask_host(0.05, 1e-3);
  EXPECT_GE(answers.jitter.ticks, 50u);  // the last one may come after several more
  EXPECT_GE(answers.jitter.max_us, answers.jitter.p50_us);
  EXPECT_FALSE(answers.groups.empty());
}

}  // namespace
}  // namespace haptic::ctl
