#include "tests/relay/network_row.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "tests/relay/matrix_table.hpp"

namespace haptic::test {

bool RowRun::expect(bool holds, const std::string& what, std::optional<double> at) {
  if (holds) return true;
  if (!at) {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();  // CLOCK_MONOTONIC
    seen_live_.emplace_back(report_.findings.size(), now);
  }
  report_.findings.push_back({"not as expected: " + what, at});
  return false;
}

bool RowRun::insist(bool holds, const std::string& what) {
  if (!holds) report_.findings.push_back({"not as it must be: " + what, {}, true});
  return holds;
}

void RowRun::date_findings(std::chrono::nanoseconds origin) {
  for (const auto& [index, seen] : seen_live_) {
    report_.findings[index].at = std::chrono::duration<double>(seen - origin).count();
  }
}

const std::vector<RecordedTick>& RowRun::record() {
  if (record_.empty()) {
    insist(daemon_.stop() == 0, "the daemon's exit status 0");
    record_ = read_record(daemon_.record());
  }
  return record_;
}

const RunFigures& RowRun::judge() {
  if (!figures_) {
    figures_ = haptic::test::judge(record(), fresh_end_);
    for (const Finding& breach : figures_->breaches) report_.findings.push_back(breach);
  }
  return *figures_;
}

std::optional<std::chrono::nanoseconds> RowRun::origin() const {
  if (!first_) return {};
  const auto tick = std::find_if(record_.begin(), record_.end(),
                                 [&](const RecordedTick& t) { return t.tick == first_->seq; });
  if (tick == record_.end()) return {};
  return std::chrono::nanoseconds(first_->server_time_ns - std::llround(1e9 * tick->time));
}

/// Until the host has left the processors alone for a second, for 30 s at most: a run that begins in
/// a bad spell would only have to be done again.
void await_calm_host() {
  constexpr double kBad = 0.004;  // s
  const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  for (bool calm = false; !calm && std::chrono::steady_clock::now() < latest;) {
    const HostWitness witness;
    std::this_thread::sleep_for(std::chrono::seconds(1));
    const std::vector<Stall> stalls = witness.testimony({}).stalls;
    calm = std::none_of(stalls.begin(), stalls.end(),
                        [](const Stall& stall) { return stall.to - stall.from > kBad; });
  }
}

RunReport run_once(const Experiment& experiment) {
  await_calm_host();
  const HostWitness witness;
  RowRun run;
  const auto guarded = [&](const auto& part) {
    try {
      part();
    } catch (const std::exception& error) {
      run.insist(false, std::string("no exception, but: ") + error.what());
    }
  };
  guarded([&] {
    run.first_ = first_state(run.daemon().address());
    const bool serves = run.first_ && run.first_->state == client::Lifecycle::kIdle;
    if (run.expect(serves, "a daemon that serves an idle finger at rest")) experiment(run);
  });
  guarded([&] {
    static_cast<void>(run.judge());
    if (const auto origin = run.origin()) {
      const Testimony testimony = witness.testimony(*origin);
      const auto skipped = too_many_skipped(run.record_, testimony);
      run.expect(!skipped, "at most 0.5 %, not " + skipped.value_or(""), run.record_.back().time);
      run.date_findings(*origin);
      run.report_.excuse = host_excuse(run.record_, testimony, run.report_.findings);
    }
  });
  run.report_.witness = witness.summary();
  return std::move(run.report_);
}

void network_row(const std::string& name, const std::string& expected,
                 const Experiment& experiment) {
  MatrixRow row("network/" + name, expected);
  const RowReport report = until_a_run_counts([&] { return run_once(experiment); });
  for (const std::string& failure : report.failures) ADD_FAILURE() << failure;
  for (const std::string& part : report.got) row.got(part);
}

}  // namespace haptic::test
