#pragma once
/// A row of the matrix over real sockets: an experiment with a daemon of its own, done again where
/// the host took the processors away (host_excuse.hpp), judged by the run that counts.
///
///   network_row("nan", "refused and counted", [](RowRun& run) {
///     Presser presser(run.daemon().address());
///     if (!run.expect(within(5s, ...), "engaged")) return;
///     run.got(run.judge().text());
///   });
///
/// Nothing in an experiment may fail the test by itself, and nothing outlives it: it may run three
/// times.

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/relay/daemon.hpp"
#include "tests/relay/host_excuse.hpp"
#include "tests/relay/host_witness.hpp"
#include "tests/relay/presser.hpp"
#include "tests/relay/run_record.hpp"

namespace haptic::test {

class RowRun {
 public:
  [[nodiscard]] Daemon& daemon() { return daemon_; }

  /// Of the row's client, if it is not a Presser; before what is judged.
  void client_rate(double hz) { fresh_end_ = 2.5 / hz; }

  /// `what` should be, and is where `holds`; else a finding of this moment, or of `at` (s, of the
  /// record), which a stall of the host before it excuses. Returns `holds`.
  bool expect(bool holds, const std::string& what, std::optional<double> at = {});
  /// The same of what no stall can be the reason for: a final finding.
  bool insist(bool holds, const std::string& what);
  /// For the table.
  void got(const std::string& part) { report_.got.push_back(part); }

  /// What the daemon recorded; ends it. Throws std::runtime_error where there is no record.
  [[nodiscard]] const std::vector<RecordedTick>& record();
  /// Holds the contract against it; a breach is a finding. Done for every run, asked for or not.
  const RunFigures& judge();

 private:
  friend RunReport run_once(const std::function<void(RowRun&)>& experiment);
  /// A clock that is 0 where the record's is, in CLOCK_MONOTONIC; the record must be there.
  [[nodiscard]] std::optional<std::chrono::nanoseconds> origin() const;

  /// Gives what was found live its time.
  void date_findings(std::chrono::nanoseconds origin);

  Daemon daemon_{};
  RunReport report_{};
  /// Which of its findings were seen live, and when, in CLOCK_MONOTONIC.
  std::vector<std::pair<std::size_t, std::chrono::nanoseconds>> seen_live_{};
  double fresh_end_{Presser::kFreshEnd};  ///< s
  std::optional<RunFigures> figures_{};
  std::optional<client::DeviceState> first_{};  ///< a tick by both clocks
  std::vector<RecordedTick> record_{};
};

using Experiment = std::function<void(RowRun&)>;

/// One run under the witness's eyes, with a daemon that serves; whatever it throws is a final
/// finding.
[[nodiscard]] RunReport run_once(const Experiment& experiment);

/// The row "network/`name`" of the table, and the verdict of the test that it runs in.
void network_row(const std::string& name, const std::string& expected,
                 const Experiment& experiment);

}  // namespace haptic::test
