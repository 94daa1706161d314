#pragma once
/// A row of the matrix over real sockets: one experiment with a hapticd of its own.
///
///   network_row("nan", "refused and counted", [](RowRun& run) {
///     Presser presser(run.daemon().address());
///     if (!run.must(within(60s, ...), "engaged")) return;
///     run.got(run.judge().text());
///   });

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/relay/daemon.hpp"
#include "tests/relay/presser.hpp"
#include "tests/relay/relay.hpp"
#include "tests/relay/run_record.hpp"

namespace haptic::test {

/// The host does nothing else (HAPTIC_CALM is set: label `calm`), so times are judged too.
[[nodiscard]] bool host_is_calm();

class RowRun {
 public:
  [[nodiscard]] Daemon& daemon() { return daemon_; }

  /// A rule that must hold on any host, busy or not. Returns `holds`.
  bool must(bool holds, const std::string& what);
  /// A rule that a busy host may break, because our threads then run late. It is a failure on a
  /// calm host and a remark on any other. Returns `holds`.
  bool calm(bool holds, const std::string& what);
  /// Adds to the table.
  void got(const std::string& part) { got_.push_back(part); }

  /// The daemon's recording; ends the daemon. Throws std::runtime_error if there is no record.
  [[nodiscard]] const std::vector<RecordedTick>& record();
  /// Holds the contract against the record. Every row is judged, even if it does not ask.
  const RunFigures& judge();

  [[nodiscard]] const std::vector<std::string>& failures() const { return failures_; }
  [[nodiscard]] const std::vector<std::string>& got() const { return got_; }

 private:
  Daemon daemon_{};
  std::vector<std::string> failures_{}, got_{};
  std::optional<RunFigures> figures_{};
  std::vector<RecordedTick> record_{};
};

/// A relay between clients and the daemon.
[[nodiscard]] RelaySetup relay_to(const Daemon& daemon, const Scenario& scenario);
[[nodiscard]] RelaySetup relay_to(const Daemon& daemon, const std::string& shipped);

/// Runs the row "network/`name`", writes it to the table, and fails the current test if the row
/// fails.
void network_row(const std::string& name, const std::string& expected,
                 const std::function<void(RowRun&)>& experiment);

}  // namespace haptic::test
