#pragma once
/// The force loop's figures, measured on the rig: the finger's tip held (the hardest case for
/// stability), a step of the reference, the force in the cell.

#include "hw/emulator/emulated_board.hpp"

namespace haptic::hw::emulator {

struct ForceStep {
  double rise{0.0};       ///< s, 10 to 90 % of the step
  double bandwidth{0.0};  ///< Hz: 0.35 / rise, that of a first-order response with this rise
  double overshoot{0.0};  ///< share of the step
  bool settled{false};    ///< within 5 % of the step (and the cell's noise) in the last of 2 s
};

/// `from` and `to` in N. `l`: where the linkage is held, m.
[[nodiscard]] ForceStep measure_force_step(const EmulatorConfig& config, double from, double to,
                                           double l = 0.02);

}  // namespace haptic::hw::emulator
