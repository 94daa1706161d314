#pragma once
/// The one-DoF experiment of core/METHOD.md#local-models on the real Pipeline: a mass that a hand
/// presses on a wall through a spring and a damper, or moves in and out of it, with the simulation
/// of the wall behind a network.

#include "haptic/core/passivity/passivity.hpp"
#include "tests/support/loop/remote_client.hpp"

namespace haptic::test {

/// In and out: amplitude 20 mm at 1 Hz, hence a mean speed of 80 mm/s, core/METHOD.md#local-models.
inline constexpr double kWallAmplitude = 0.020;               ///< m
inline constexpr double kWallMeanSpeed = 4 * kWallAmplitude;  ///< m/s

struct WallRun {
  bool cycles{true};         ///< in and out once a second, 8 s; else a steady press, 4 s
  double stiffness{1500.0};  ///< Z_q, N/m
  ClientSettings client{};   ///< its one stop is the wall, m
  core::PassivitySettings passivity{};
};

/// A client of 60 Hz, 20 ms late, jitter 30 %, at a wall at 0.
[[nodiscard]] WallRun wall_run(core::ProxyMode mode = core::ProxyMode::kPlanes);
/// The tank alone, with what the mass's own damping takes. `initial`: tank_0, J.
[[nodiscard]] core::PassivitySettings wall_tank(double initial);

struct WallFigures {
  double rms_speed{0.0};   ///< over the last second, m/s
  double top_speed{0.0};   ///< m/s
  double largest_q{0.0};   ///< m
  double drag{0.0};        ///< mean of the force's magnitude while outside the wall, N
  double peak_force{0.0};  ///< N
  double most_given{0.0};  ///< largest over time of the work on the device, J
  double most_net{0.0};    ///< the same less what the device's own damping took, J
  int throttled{0};        ///< ticks
};

/// Throws SceneError if force never came on. Ends early, with both speeds infinite, if the mass
/// reaches the device's end: its stop would decide the rest.
[[nodiscard]] WallFigures run(const WallRun& what);

}  // namespace haptic::test
