#pragma once
/// The one-DoF experiment of core/METHOD.md#local-models (tests/support/loop/wall_run.hpp) for the
/// clients and networks of `rate`, and how stiff the wall may be before it is unstable.

#include "tests/report/client_kind.hpp"
#include "tests/support/loop/wall_run.hpp"

namespace haptic::report {

using test::kWallAmplitude;
using test::kWallMeanSpeed;
using test::WallFigures;

struct WallLoop {
  bool cycles{false};       ///< in and out once a second; else a steady press
  double stiffness{500.0};  ///< Z_q, N/m
  bool tank{false};  ///< strictly passive: tank_0 = 0, P_env = 0 (core/METHOD.md#energy-tank)
  ClientKind kind{ClientKind::kHeld};
  Network network{};
};

/// Throws SceneError where force never came on.
[[nodiscard]] WallFigures run(const WallLoop& what);

/// core/METHOD.md#local-models: a press is stable where the rms speed ends below 1 mm/s. In and
/// out: where nothing is ever faster than twice the hand's own fastest.
[[nodiscard]] bool stable(const WallLoop& what, const WallFigures& figures) noexcept;

/// The largest stiffness of the grid 25 x 1.1^n N/m, n = 0..kTop, up to which the loop is stable; 0
/// where not even the first is. Steps of 1.1^4 first: an island of instability smaller than that
/// may be missed.
inline constexpr int kTop = 60;
[[nodiscard]] double grid_stiffness(int n) noexcept;
[[nodiscard]] double largest_stiffness(WallLoop what);

}  // namespace haptic::report
