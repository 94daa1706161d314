// The least error that any rule can have if the mass of a sliding object is told half or double
// (core/METHOD.md#pushed-objects). For a round trip after the touch the server hears nothing of the
// object's motion, so every rule gives the same force in both cases. Here that force is the best
// mixture of the two right ones, and after the round trip the right one is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/support/loop/rails.hpp"

namespace haptic::test {
namespace {

constexpr double kFelt = 375.0;    // N/m: 500 N/m of the contact behind the coupling
constexpr double kDamping = 20.0;  // N s/m, between object and ground

struct Sliding {
  double mass{0.0}, s{0.0}, v{0.0};

  /// Force on a probe that moves from `before` to `now` in a tick, at its end.
  double push(double before, double now) {
    constexpr int kSteps = 20;
    constexpr double dt = 1e-3 / kSteps;
    for (int i = 1; i <= kSteps; ++i) {
      v += dt * kFelt * std::max(0.0, before + (now - before) * i / kSteps - s) / mass;
      v /= 1.0 + dt * kDamping / mass;
      s += dt * v;
    }
    return kFelt * std::max(0.0, now - s);
  }
};

/// Rms error in contact over the peak if world `real` is so, with the share `mixed` of world 0's
/// force before `unheard` s have gone since the touch.
double error(std::array<Sliding, 2> worlds, std::size_t real, double mixed, double unheard) {
  HandMasses hand(swinging(0.7, 0.018));
  double before = hand.q()[0], tau = 0.0, touched = -1.0, squares = 0.0, peak = 0.0;
  int ticks = 0;
  for (int k = 1; k <= 1400; ++k) {
    const double t = 1e-3 * k;
    hand.step(t, core::VecA::Constant(1, -tau));
    const double now = hand.q()[0];
    std::array<double, 2> right{};
    for (std::size_t i = 0; i < 2; ++i) right[i] = worlds[i].push(before, now);
    before = now;
    if (touched < 0.0 && now > 0.0) touched = t;
    if (touched < 0.0) continue;
    tau = t < touched + unheard ? mixed * right[0] + (1.0 - mixed) * right[1] : right[real];
    if (right[real] == 0.0) continue;
    squares += (tau - right[real]) * (tau - right[real]);
    peak = std::max(peak, right[real]);
    ++ticks;
  }
  return std::sqrt(squares / ticks) / peak;
}

double best(double told, double unheard) {
  const std::array<Sliding, 2> worlds{{{.mass = told / 2.0}, {.mass = 2.0 * told}}};
  double least = INFINITY;
  for (int i = 0; i <= 20; ++i) {
    const double mixed = i / 20.0;
    least = std::min(least,
                     std::max(error(worlds, 0, mixed, unheard), error(worlds, 1, mixed, unheard)));
  }
  return least;
}

TEST(UnknownMass, NoRuleFeelsIt) {
  EXPECT_LT(best(4.0, 0.1), 0.05);
  EXPECT_NEAR(best(1.0, 0.2), 0.11, 0.002);
  EXPECT_NEAR(best(4.0, 0.2), 0.095, 0.002);
}

}  // namespace
}  // namespace haptic::test
