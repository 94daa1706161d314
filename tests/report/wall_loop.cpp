#include "tests/report/wall_loop.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::report {

WallFigures run(const WallLoop& what) {
  test::WallRun wall;
  wall.cycles = what.cycles;
  wall.stiffness = what.stiffness;
  wall.client = client_of(what.kind, what.network, core::VecX::Zero(1));
  wall.passivity = test::wall_tank(0.0);
  wall.passivity.tank.enabled = what.tank;
  return test::run(wall);
}

bool stable(const WallLoop& what, const WallFigures& figures) noexcept {
  constexpr double kStill = 1e-3;  // m/s, core/METHOD.md#local-models
  constexpr double kFastestHand = 2.0 * M_PI * kWallAmplitude;
  return what.cycles ? figures.top_speed <= 2.0 * kFastestHand : figures.rms_speed < kStill;
}

double grid_stiffness(int n) noexcept {
  return 25.0 * std::pow(1.1, n);
}

double largest_stiffness(WallLoop what) {
  constexpr int kStride = 4;
  const auto holds = [&what](int n) {
    what.stiffness = grid_stiffness(n);
    return stable(what, run(what));
  };
  int good = -1;
  while (good + kStride <= kTop && holds(good + kStride)) good += kStride;
  for (int end = std::min(good + kStride - 1, kTop); good < end && holds(good + 1);) ++good;
  return good < 0 ? 0.0 : grid_stiffness(good);
}

}  // namespace haptic::report
