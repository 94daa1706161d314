#pragma once
/// Reads the recording of a run (hapticd's `record`, every tick) and holds the contract of
/// proto/README.md#staleness-and-gain and tests/relay/README.md#rows against it, tick by tick.
/// It uses none of the server's code.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace haptic::test {

struct RecordedTick {
  double time{0.0};  ///< s, since the first tick recorded
  std::uint64_t tick{0};
  std::string state{}, staleness{}, mode{}, faults{}, limiters{};
  double age{0.0};  ///< s, of the proxy
  double gain{0.0};
  double slide{0.0};                    ///< l_x, m
  double body{0.0};                     ///< q_B, rad
  double tau_elastic{0.0}, tau_a{0.0};  ///< N
  double lateness{0.0};                 ///< s, of the wake-up after its deadline
  double skipped{0.0};
  std::optional<double> error_bound{};  ///< N
};

/// Throws std::runtime_error if a column is missing.
[[nodiscard]] std::vector<RecordedTick> read_record(const std::filesystem::path& file);

/// Summary of a run.
struct RunFigures {
  int engages{0};  ///< how often ENGAGING was entered
  int losses{0};   ///< how often an old proxy took the force: ENGAGING or ENGAGED to ARMED
  bool engaged{false};
  double oldest{0.0};    ///< s, oldest proxy while force was on
  double steepest{0.0};  ///< N/s, of a rising force
  double energy{0.0};    ///< J, the most that was given out, net of the device's damping
  double skipped{0.0};   ///< deadlines
  double latest{0.0};    ///< s, the largest lateness of a tick
  std::string last_state{};
  std::string breach{};  ///< the contract's first breach, with its time; empty: none
  [[nodiscard]] std::string text() const;  ///< for the table
};

/// Judges rules that hold for every tick, however late it is: levels and gain by age, the force's
/// limits and steps, no fault, no more energy than the tank held, and in a fault no gain at once
/// and no command from the second tick on. `fresh_end` s.
[[nodiscard]] RunFigures judge(const std::vector<RecordedTick>& run, double fresh_end);

}  // namespace haptic::test
