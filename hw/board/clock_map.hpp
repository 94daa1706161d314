#pragma once
/// Maps the board's clock to the server's steady clock: it tells when a sample was measured that
/// arrived now.
///
/// arrival - board time = offset + drift * board time + delay of the link, with delay >= 0 and
/// sometimes large. Offset and drift come from a least-squares line whose weights decay with
/// kMemory. Arrivals far above the line are stragglers and do not move it. Samples are placed two
/// mean deviations below the line, near the earliest arrivals. A constant delay is invisible in one
/// direction: samples look younger by at most the shortest delay of the link. Reads no clock,
/// allocates nothing.

#include <cstdint>

#include "haptic/core/time.hpp"

namespace haptic::hw::board {

class ClockMap {
 public:
  static constexpr double kMemory = 2.0;  ///< s
  static constexpr double kStep = 0.1;    ///< s: a larger difference means that a clock was reset
  static constexpr double kMaxDrift = 1e-3;   ///< crystals stay below 200 ppm; more is noise
  static constexpr double kStraggler = 5e-4;  ///< s above the line, at least, to be ignored
  static constexpr int kRelearn = 100;        ///< stragglers in a row: the delay itself has changed

  /// Learns from the sample and returns when it was measured: never after `arrival`.
  [[nodiscard]] core::TimePoint map(std::uint64_t board_us, core::TimePoint arrival) noexcept;
  /// Forgets everything: another board, or the same one restarted.
  void restart() noexcept { *this = ClockMap{}; }

 private:
  void begin(std::uint64_t board_us, core::TimePoint arrival) noexcept;
  void fit(double elapsed, double offset) noexcept;

  bool begun_{false};
  std::uint64_t board_0_{0}, last_board_{0};
  core::TimePoint arrival_0_{};
  // Decayed sums over (age, offset), age = board time since the newest sample, <= 0.
  double s0_{0.0}, s1_{0.0}, s2_{0.0}, y0_{0.0}, y1_{0.0};
  double offset_{0.0}, drift_{0.0};  ///< the line at the newest sample; s, s/s of steady by board
  double deviation_{0.0};            ///< from the line, mean, s
  int stragglers_in_a_row_{0};
};

}  // namespace haptic::hw::board
