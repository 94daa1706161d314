#pragma once
/// The recording of a run (hapticd's `record`, every tick), and the contract of WIRE 4 and 6 held against it
/// tick by tick. Nothing of the server's own code judges here.

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
  [[nodiscard]] std::string text() const {
    return at ? "at " + std::to_string(*at) + " s: " + what : what;
  }
};

/// Throws std::runtime_error where a column is missing.
[[nodiscard]] std::vector<RecordedTick> read_record(const std::filesystem::path& file);

/// What a run looked like, for the table.
struct RunFigures {
  bool engaged{false};
  int engages{0};        ///< ENGAGING was entered
  int losses{0};         ///< force was given up for an old proxy: from ENGAGING or ENGAGED to ARMED
  double oldest{0.0};    ///< s, while force was on
  double steepest{0.0};  ///< N/s, of a rising force
  double energy{0.0};    ///< J, the most that was given out, net of the device's damping
  double skipped{0.0};   ///< deadlines
  std::string last_state{};
  std::optional<Finding> breach{};  ///< the first one of the contract; absent: none
  [[nodiscard]] std::string text() const;
};

/// `fresh_end` s.
[[nodiscard]] RunFigures judge(const std::vector<RecordedTick>& run, double fresh_end);

}  // namespace haptic::test
