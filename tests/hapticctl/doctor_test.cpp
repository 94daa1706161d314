#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "doctor/checks.hpp"
#include "doctor/examine.hpp"
#include "doctor/measure.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::ctl {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// The files of a made-up host, below a folder of its own.
class FakeHost {
 public:
  FakeHost& file(const std::string& path, const std::string& text) {
    const fs::path full = root_.path() / fs::path(path).relative_path();
    fs::create_directories(full.parent_path());
    std::ofstream(full) << text;
    return *this;
  }
  [[nodiscard]] HostFiles files() const { return HostFiles(root_.path()); }

 private:
  test::ScratchFolder root_{};
};

/// A host without a problem; each test then spoils something.
struct Doctor : ::testing::Test {
  Doctor() {
    host.file("/proc/sys/kernel/osrelease", "6.1.0-rt-amd64\n")
        .file("/sys/kernel/realtime", "1\n")
        .file("/proc/self/cgroup", "0::/user.slice\n")
        .file("/sys/fs/cgroup/user.slice/cpu.max", "max 100000\n")
        .file("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n");
    answers.jitter = {10'000, 0, 20.0, 50.0, 120.0};
  }
  [[nodiscard]] Report examined() const { return examine(host.files(), answers, {}); }
  [[nodiscard]] Finding realtime() const { return check_realtime(answers); }
  [[nodiscard]] StiffnessCap cap(double device_damping, double rendered_damping) const {
    return examine(host.files(), answers, {1e-3, device_damping, rendered_damping}).cap;
  }

  FakeHost host;
  HostAnswers answers;
};

TEST_F(Doctor, GoodHostIsRealTime) {
  const Report report = examined();
  EXPECT_EQ(report.grade, "real-time");
  for (const Finding& f : report.findings) {
    EXPECT_EQ(f.health, Health::kGood) << f.what << ": " << f.found;
    EXPECT_TRUE(f.advice.empty()) << f.what;
  }
}

TEST_F(Doctor, UnknownHostIsDegraded) {
  const Report report = examine(FakeHost().files(), answers, {});
  EXPECT_EQ(report.grade, "degraded");
  EXPECT_EQ(report.findings.at(0).what, "kernel");
  EXPECT_THAT(report.findings.at(0).found, HasSubstr("unknown"));
}

TEST_F(Doctor, SaysWhyRealTimeWasRefused) {
  answers.fifo_error = EPERM;
  EXPECT_EQ(realtime().health, Health::kImpaired);
  EXPECT_THAT(realtime().found, HasSubstr("EPERM"));
  EXPECT_THAT(realtime().advice, HasSubstr("usermod -aG haptic"));

  answers.sys_nice = true;
  EXPECT_THAT(realtime().found, HasSubstr("CAP_SYS_NICE is held"));
}

TEST_F(Doctor, MemoryNeedsNoLimitOrCapability) {
  answers.memlock = 8 * 1024 * 1024;
  EXPECT_EQ(check_memory(answers).health, Health::kImpaired);
  EXPECT_THAT(check_memory(answers).found, HasSubstr("8192 KB"));
  answers.ipc_lock = true;
  EXPECT_EQ(check_memory(answers).health, Health::kGood);
}

TEST_F(Doctor, SleepingProcessorsNeedTheGroup) {
  EXPECT_EQ(check_idle(answers).health, Health::kGood);
  answers.idle_error = EACCES;
  EXPECT_EQ(check_idle(answers).health, Health::kImpaired);
  EXPECT_THAT(check_idle(answers).found, HasSubstr("EACCES"));
  EXPECT_THAT(check_idle(answers).advice, HasSubstr("usermod -aG haptic"));
  answers.idle_error = ENOENT;
  EXPECT_THAT(check_idle(answers).advice, HasSubstr("--device"));
}

TEST_F(Doctor, TightestCpuBudgetOfParentsCounts) {
  const auto judged = [&](const char* cgroup, std::map<const char*, const char*> files) {
    host.file("/proc/self/cgroup", cgroup);
    for (const auto& [path, text] : files) host.file(std::string("/sys/fs/cgroup/") + path, text);
    return check_cgroup(host.files());
  };
  Finding f = judged("0::/a\n", {{"a/cpu.max", "max 100000"}});
  EXPECT_EQ(f.found, "no CPU limit");
  f = judged("0::/a\n", {{"a/cpu.max", "400000 100000"}});
  EXPECT_EQ(f.health, Health::kGood);
  EXPECT_EQ(f.found, "limited to 4.00 CPUs");
  f = judged("0::/a/b\n", {{"a/b/cpu.max", "200000 100000"}, {"a/cpu.max", "50000 100000"}});
  EXPECT_EQ(f.health, Health::kBad);
  EXPECT_THAT(f.found, HasSubstr("stands still for up to 50 ms"));
}

TEST_F(Doctor, NamesCpusWithAnotherGovernor) {
  host.file("/sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave\n");
  const Finding f = check_governor(host.files());
  EXPECT_EQ(f.health, Health::kImpaired);
  EXPECT_THAT(f.found, HasSubstr("cpu1 powersave"));
  EXPECT_THAT(f.found, Not(HasSubstr("cpu0")));
}

TEST_F(Doctor, ForbiddenPortNamesItsGroup) {
  host.file("/dev/ttyACM0", "");
  EXPECT_EQ(check_serial(host.files(), answers).at(0).health, Health::kGood);
  answers.closed_ports = {{"/dev/ttyACM0", "dialout"}};
  const Finding f = check_serial(host.files(), answers).at(0);
  EXPECT_EQ(f.health, Health::kBad);
  EXPECT_THAT(f.advice, HasSubstr("usermod -aG dialout"));
}

TEST_F(Doctor, SlowAdapterLowersTheCap) {
  host.file("/dev/ttyUSB0", "")
      .file("/sys/bus/usb-serial/devices/ttyUSB0/latency_timer", "16\n")
      .file("/dev/ttyUSB1", "")
      .file("/sys/bus/usb-serial/devices/ttyUSB1/latency_timer", "1\n");
  const auto findings = check_serial(host.files(), answers);
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].health, Health::kImpaired);
  EXPECT_THAT(findings[0].advice, HasSubstr("ttyUSB0/latency_timer"));
  EXPECT_EQ(findings[1].health, Health::kGood);
  EXPECT_DOUBLE_EQ(serial_latency(host.files()), 0.016);
  answers.jitter = {10'000, 0, 0.0, 0.0, 0.0};
  EXPECT_NEAR(cap(1.0, 0.0).stable, 1.0 / 16.5e-3, 1e-9);
}

TEST_F(Doctor, JudgesJitterByPeriodAndFault) {
  EXPECT_EQ(check_jitter({10'000, 0, 10.0, 60.0, 300.0}, 1e-3).health, Health::kGood);
  EXPECT_EQ(check_jitter({10'000, 0, 40.0, 140.0, 300.0}, 1e-3).health, Health::kImpaired);
  EXPECT_EQ(check_jitter({10'000, 3, 10.0, 60.0, 4000.0}, 1e-3).health, Health::kImpaired);
  EXPECT_EQ(check_jitter({10'000, 9, 10.0, 60.0, 9000.0}, 1e-3).health, Health::kBad);
  EXPECT_EQ(check_jitter({}, 1e-3).health, Health::kBad);
}

TEST_F(Doctor, WorstFindingIsTheGrade) {
  answers.jitter.p99_us = 500.0;
  EXPECT_EQ(examined().grade, "degraded");
  host.file("/sys/fs/cgroup/user.slice/cpu.max", "10000 100000\n");
  EXPECT_EQ(examined().grade, "unfit");
}

// core/METHOD.md#sampled-data: passive up to 2 (b - B) / hold, stable up to (b + B) / (T / 2 +
// t_d).
TEST_F(Doctor, StiffnessCapFollowsDampingAndDelay) {
  answers.jitter = {10'000, 0, 0.0, 0.0, 0.0};
  EXPECT_NEAR(cap(1.0, 0.0).passive, 2000.0, 1e-9);
  EXPECT_NEAR(cap(1.0, 0.0).stable, 2000.0, 1e-9);
  EXPECT_NEAR(cap(2.0, 0.5).passive, 3000.0, 1e-9);
  EXPECT_NEAR(cap(2.0, 0.5).stable, 5000.0, 1e-9);
  EXPECT_EQ(cap(1.0, 1.5).passive, 0.0);
  // A wake-up 1 ms late holds a force for 2 ms; 3 ms of delay: K < b / 3.5 ms.
  answers.jitter = {10'000, 0, 0.0, 3000.0, 1000.0};
  EXPECT_NEAR(cap(1.0, 0.0).passive, 1000.0, 1e-9);
  EXPECT_NEAR(cap(1.0, 0.0).stable, 1.0 / 3.5e-3, 1e-9);
}

TEST_F(Doctor, PercentilesAreThoseOfTheRank) {
  std::vector<double> lateness;
  for (int i = 100; i >= 1; --i) lateness.push_back(i);
  const Jitter jitter = summarise(lateness, 7);
  EXPECT_EQ(jitter.p50_us, 50.0);
  EXPECT_EQ(jitter.p99_us, 99.0);
  EXPECT_EQ(jitter.max_us, 100.0);
  EXPECT_EQ(jitter.ticks, 107u);
  EXPECT_EQ(summarise({}, 0).ticks, 0u);
}

TEST_F(Doctor, JsonAndTextSayTheSame) {
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
    EXPECT_THAT(text, AllOf(HasSubstr(f.found), HasSubstr(f.advice)));
  }
  EXPECT_THAT(text, HasSubstr("grade: degraded"));
}

TEST_F(Doctor, MeasuresThisVeryHost) {
  const HostAnswers measured = ask_host(0.05, 1e-3);
  EXPECT_GE(measured.jitter.ticks, 50u);  // the last one may come after several more
  EXPECT_GE(measured.jitter.max_us, measured.jitter.p50_us);
}

}  // namespace
}  // namespace haptic::ctl
