#pragma once
/// METHOD 5.4's one-DoF experiment on the real Pipeline: a mass that a hand presses on a wall at 0, or
/// moves in and out of it, with the simulation of the wall behind a network.

#include "tests/report/client_kind.hpp"

namespace haptic::report {

struct WallLoop {
  bool cycles{false};       ///< in and out once a second; else a steady press
  double stiffness{500.0};  ///< Z_q, N/m
  bool tank{false};         ///< strictly passive: tank_0 = 0, P_env = 0 (METHOD 5.3)
  ClientKind kind{ClientKind::kHeld};
  Network network{};
};

/// In and out: amplitude 20 mm at 1 Hz, hence a mean speed of 80 mm/s, METHOD 5.4.
inline constexpr double kWallAmplitude = 0.020;               ///< m
inline constexpr double kWallMeanSpeed = 4 * kWallAmplitude;  ///< m/s

struct WallFigures {
  double rms_speed{0.0};   ///< over the last second, m/s
  double top_speed{0.0};   ///< m/s
  double drag{0.0};        ///< mean of the force's magnitude while outside the wall, N
  double peak_force{0.0};  ///< N
  double most_given{0.0};  ///< largest over time of the work on the device, J
  double most_net{0.0};    ///< the same less what the device's own damping took, J
  int throttled{0};        ///< ticks
};

/// Throws SceneError where force never came on. Ends early where the mass reaches the device's end.
[[nodiscard]] WallFigures run(const WallLoop& what);

/// METHOD 5.4: a press is stable where the rms speed ends below 1 mm/s. In and out: where nothing is
/// ever faster than twice the hand's own fastest.
[[nodiscard]] bool stable(const WallLoop& what, const WallFigures& figures) noexcept;

/// The largest stiffness of the grid 25 x 1.1^n N/m, n = 0..kTop, up to which the loop is stable; 0
/// where not even the first is. Steps of 1.1^4 first: an island of instability smaller than that may
/// be missed.
inline constexpr int kTop = 60;
[[nodiscard]] double grid_stiffness(int n) noexcept;
[[nodiscard]] double largest_stiffness(WallLoop what);

}  // namespace haptic::report
