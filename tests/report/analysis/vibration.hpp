#pragma once
/// Vibration of a force between 50 and 500 Hz, and whether a finger would notice it. The latter is
/// predicted from published thresholds; no people took part (tests/report/STUDY.md#feel).

#include <functional>
#include <span>

#include <Eigen/Core>

#include "hw/simulated/finger_physics.hpp"

namespace haptic::report {

inline constexpr double kLowest_hz = 50.0, kHighest_hz = 500.0;

/// Least amplitude (peak, m) that a finger notices at `hz`, 40 to 500: the Pacinian channel, 0.1 um
/// at 250 to 300 Hz and 12 dB per octave more on both sides (S. J. Bolanowski, G. A. Gescheider,
/// R. T. Verrillo, C. M. Checkosky, "Four channels mediate the mechanical aspects of touch",
/// J. Acoust. Soc. Am. 84(5):1680-1694, 1988).
[[nodiscard]] double vibration_threshold(double hz) noexcept;

/// Way of a worn finger's tip, 40 mm beyond the PIP axis, per N at the actuator, m/N, at `hz`: the
/// model of hw/simulated/finger_physics.hpp about the pose x (rad) with the lever w (m/rad).
[[nodiscard]] double tip_compliance(const hw::FingerParameters& finger, const Eigen::Vector2d& x,
                                    const Eigen::Vector2d& w, double hz) noexcept;

/// Root mean square of `samples` (1 kHz, a power of two, at least 64) between kLowest_hz and
/// kHighest_hz, behind a Hann window, each frequency times weight(hz).
[[nodiscard]] double band_rms(
    std::span<const double> samples,
    const std::function<double(double hz)>& weight = [](double) { return 1.0; });

/// The same over all of a run, in segments of 256 samples half over each other; 0 if it is shorter.
[[nodiscard]] double run_band_rms(std::span<const double> samples);

}  // namespace haptic::report
