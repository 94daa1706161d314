#pragma once
/// The recording of a run (hapticd's `record`, every tick), and the contract of
/// proto/README.md#staleness-and-gain and tests/relay/README.md#rows held against it tick by tick.
/// Nothing of the server's own code judges here.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace haptic::test {

struct RecordedTick {
  double time{0.0};  ///< s, since the first tick recorded
  std::uint64_t tick{0};
  std::string state{}, staleness{}, mode{}, faults{};
  double age{0.0};  ///< s, of the proxy
  double gain{0.0};
  double slide{0.0};                    ///< l_x, m
  double tau_elastic{0.0}, tau_a{0.0};  ///< N
  double lateness{0.0};                 ///< s, of the wake-up after its deadline
  double skipped{0.0};
};

/// Something that was wrong with a run.
struct Finding {
  std::string what{};
  std::optional<double> at{};  ///< s, of the record; absent: of the run as a whole
  bool is_final{false};        ///< no lateness is a reason for it: never excused
  [[nodiscard]] std::string text() const {
    return at ? "at " + std::to_string(*at) + " s: " + what : what;
  }
};

/// Throws std::runtime_error where a column is missing.
[[nodiscard]] std::vector<RecordedTick> read_record(const std::filesystem::path& file);

/// What a run looked like, for the table.
struct RunFigures {
  bool engaged{false};
  int engages{0};  ///< ENGAGING was entered
  int losses{0};   ///< force was given up for an old proxy: from ENGAGING or ENGAGED to ARMED
  std::optional<double> last_loss{};  ///< s, of the record
  double oldest{0.0};                 ///< s, while force was on
  double steepest{0.0};               ///< N/s, of a rising force
  double energy{0.0};   ///< J, the most that was given out, net of the device's damping
  double skipped{0.0};  ///< deadlines
  std::string last_state{};
  /// Of the contract: the first that lateness may be a reason for (a fault, energy), and the first
  /// that is final, in the order in which they came; empty: none.
  std::vector<Finding> breaches{};
  [[nodiscard]] std::string text() const;
};

/// To the record's end, whatever was found. Final is all that proto/README.md#staleness-and-gain
/// promises of a tick by itself, however late it was: levels and gain by age, the force's limits
/// and steps, and in a fault no gain at once and no command from the second tick on. `fresh_end` s.
[[nodiscard]] RunFigures judge(const std::vector<RecordedTick>& run, double fresh_end);

}  // namespace haptic::test
