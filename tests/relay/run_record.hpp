#pragma once
/// The recording of a run (hapticd's `record`, every tick), and the contract of WIRE 4 and 6 held against it
/// tick by tick. Nothing of the server's own code judges here.

#include <filesystem>
#include <string>
#include <vector>

namespace haptic::test {

struct RecordedTick {
  double time{0.0};  ///< s
  std::string state{}, staleness{}, mode{}, faults{};
  double age{0.0};  ///< s, of the proxy
  double gain{0.0};
  double slide{0.0};                    ///< l_x, m
  double tau_elastic{0.0}, tau_a{0.0};  ///< N
  double skipped{0.0};
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
  [[nodiscard]] std::string text() const;
};

/// `fresh_end` s. `wrong`: the first breach of the contract, with its time; empty: none.
[[nodiscard]] RunFigures judge(const std::vector<RecordedTick>& run, double fresh_end,
                               std::string& wrong);

}  // namespace haptic::test
