#include "tests/relay/network_row.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/relay/matrix_table.hpp"

namespace haptic::test {
namespace {

constexpr double kLoopLate = 0.008;       // s, proto/README.md#states-of-a-device
constexpr double kSkippedAtMost = 0.005;  // of the ticks

}  // namespace

bool host_is_calm() {
  return std::getenv("HAPTIC_CALM") != nullptr;
}

bool RowRun::must(bool holds, const std::string& what) {
  if (!holds) failures_.push_back("not as it must be: " + what);
  return holds;
}

bool RowRun::calm(bool holds, const std::string& what) {
  if (host_is_calm()) return must(holds, what);
  if (!holds) got_.push_back("not on this host: " + what);
  return holds;
}

const std::vector<RecordedTick>& RowRun::record() {
  if (record_.empty()) {
    must(daemon_.stop() == 0, "the daemon's exit status 0");
    record_ = read_record(daemon_.record());
  }
  return record_;
}

const RunFigures& RowRun::judge() {
  if (!figures_) {
    figures_ = haptic::test::judge(record(), Presser::kFreshEnd);
    must(figures_->breach.empty(), figures_->breach);
    const double ticks = static_cast<double>(record_.size());
    calm(figures_->skipped <= kSkippedAtMost * ticks, "at most 0.5 % of the deadlines skipped");
    calm(figures_->latest <= kLoopLate, "no tick later than 8 ms");
  }
  return *figures_;
}

RelaySetup relay_to(const Daemon& daemon, const Scenario& scenario) {
  RelaySetup setup;
  setup.scenario = scenario;
  setup.tcp_port = daemon.tcp_port();
  setup.udp_port = daemon.udp_port();
  return setup;
}

RelaySetup relay_to(const Daemon& daemon, const std::string& shipped) {
  return relay_to(daemon, shipped_scenario(shipped));
}

void network_row(const std::string& name, const std::string& expected,
                 const std::function<void(RowRun&)>& experiment) {
  MatrixRow row("network/" + name, expected);
  RowRun run;
  const auto guarded = [&run](const auto& part) {
    try {
      part();
    } catch (const std::exception& error) {
      run.must(false, std::string("no exception, but: ") + error.what());
    }
  };
  guarded([&] {
    if (run.must(serves(run.daemon().address()), "an idle finger at rest")) experiment(run);
  });
  guarded([&] { static_cast<void>(run.judge()); });
  for (const std::string& failure : run.failures()) ADD_FAILURE() << failure;
  for (const std::string& failure : run.failures()) row.got(failure);
  for (const std::string& part : run.got()) row.got(part);
}

}  // namespace haptic::test
