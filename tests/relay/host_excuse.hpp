#pragma once
/// Which run of a row counts. A host that takes the processors away for 12 ms makes the loop late
/// as surely as a bug of ours would; the one may be tried again, the other may not. Whoever decides
/// sees the record, what the witness saw (host_witness.hpp) and what was found wrong, and nothing
/// else: no clock, no process.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/relay/run_record.hpp"

namespace haptic::test {

/// A processor ran nothing of ours, whatever its priority; on the record's clock.
struct Stall {
  double from{0.0}, to{0.0};  ///< s
};

struct Testimony {
  /// On every processor the witness ran above everything that could be late through our own load.
  bool above_all{false};
  std::vector<Stall> stalls{};  ///< in any order, of any processor
};

/// "host stalled 12 ms at 8.9 s", where all of this holds:
///
/// - every fault of the run is LOOP_LATE or LATE_BUCKET_FULL, and there is one;
/// - LOOP_LATE: the tick was later than 8 ms (proto/README.md#states-of-a-device), and but for the
/// stalls it would have missed
///   no deadline: what no stall covers, from its deadline to its wake-up, is less than a period;
/// - LATE_BUCKET_FULL: the recorded ticks fill the bucket (proto/README.md#states-of-a-device: +5
/// per skipped deadline, -1 per
///   20 ticks on time, full at 100), and those that stalls do not explain fill less than half of
///   it;
/// - whatever else was found wrong may be a consequence of the first of these faults: it has a
/// time,
///   which is not before that tick's, and is not final. At that very tick the fault itself is
///   found, and the energy of a command that was held for too long; a wrong force there is final.
///
/// A stall of any processor counts: the loop is pinned to none, and the record does not say where
/// it was.
[[nodiscard]] std::optional<std::string> host_excuse(const std::vector<RecordedTick>& run,
                                                     const Testimony& testimony,
                                                     const std::vector<Finding>& findings);

/// "60 of 10000 deadlines skipped without a stall of the host", where these are more than 0.5 %: of
/// every skipped deadline it is asked, as above, whether its tick would have missed none but for
/// the stalls. Nothing: few enough. Every skipped one is ours where the witness was not above all.
[[nodiscard]] std::optional<std::string> too_many_skipped(const std::vector<RecordedTick>& run,
                                                          const Testimony& testimony);

struct RunReport {
  std::vector<Finding> findings{};
  std::vector<std::string> got{};       ///< for the table
  std::optional<std::string> excuse{};  ///< host_excuse()
  std::string witness{};                ///< "longest stall of the host 3 ms"
};

struct RowReport {
  std::vector<std::string> failures{};  ///< empty: the row holds
  std::vector<std::string> got{};
};

inline constexpr int kRunsAtMost = 5;

/// Runs again while the host has an excuse to give, `kRunsAtMost` times in all; the first run
/// without one counts, whatever it found. Where there is none the row fails, with the reason
/// "host".
[[nodiscard]] RowReport until_a_run_counts(const std::function<RunReport()>& run);

}  // namespace haptic::test
