#include "haptic/core/passivity/spring_storage.hpp"

#include <gtest/gtest.h>

#include <random>

namespace haptic::core {
namespace {

SpringStorage three_springs(double gain = 1.0) {
  SpringStorage s;
  s.stiffness = (VecA(3) << 1000.0, 50.0, 0.0).finished();
  s.limit = (VecA(3) << 4.0, 1.0, 2.0).finished();
  s.gain = gain;
  return s;
}

VecA stretch(double a, double b, double c = 0.0) {
  return (VecA(3) << a, b, c).finished();
}

TEST(SpringStorage, IsQuadraticThenLinear) {
  const SpringStorage s = three_springs(0.5);
  EXPECT_DOUBLE_EQ(s.energy(stretch(0.002, 0.0)), 0.5 * 0.5 * 1000.0 * 4e-6);
  // Saturates at 4 mm: 8 mJ up to there, 4 N over the further 6 mm.
  EXPECT_DOUBLE_EQ(s.energy(stretch(-0.010, 0.0)), 0.5 * (0.008 + 4.0 * 0.006));
  EXPECT_EQ(s.energy(stretch(0.0, 0.0, 5.0)), 0.0) << "no stiffness stores nothing";
}

TEST(SpringStorage, ForceIsTheEnergysGradient) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> wide(-0.03, 0.03);
  const SpringStorage s = three_springs(0.7);
  constexpr double h = 1e-7;
  for (int n = 0; n < 500; ++n) {
    const VecA d = stretch(wide(random), wide(random), wide(random));
    for (int i = 0; i < 3; ++i) {
      VecA up = d, down = d;
      up[i] += h;
      down[i] -= h;
      EXPECT_NEAR(s.force(d)[i], (s.energy(up) - s.energy(down)) / (2 * h), 1e-4);
      EXPECT_LE(std::abs(s.force(d)[i]), 0.7 * s.limit[i]);
    }
  }
}

TEST(SpringStorage, ScalingSpendsExactlyTheEnergyGiven) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> wide(-0.05, 0.05), share(0.0, 1.0);
  const SpringStorage s = three_springs(0.9);
  for (int n = 0; n < 2000; ++n) {
    const VecA d = stretch(wide(random), wide(random), wide(random));
    const double energy = share(random) * s.energy(d);
    const double scale = s.scale_to(d, energy);
    ASSERT_GE(scale, 0.0);
    ASSERT_LE(scale, 1.0);
    EXPECT_NEAR(s.energy(VecA(scale * d)), energy, 1e-14);
  }
}

TEST(SpringStorage, ScalesByTheSquareRoot) {
  const VecA d = stretch(0.003, 0.004);
  const SpringStorage s = three_springs();
  EXPECT_NEAR(s.scale_to(d, 0.25 * s.energy(d)), 0.5, 1e-15);
  EXPECT_EQ(s.scale_to(d, s.energy(d)), 1.0);
  EXPECT_EQ(s.scale_to(d, 0.0), 0.0);
  EXPECT_EQ(s.scale_to(d, -1.0), 0.0);
  EXPECT_EQ(three_springs(0.0).scale_to(d, 0.0), 1.0) << "a spring without gain costs nothing";
}

}  // namespace
}  // namespace haptic::core
