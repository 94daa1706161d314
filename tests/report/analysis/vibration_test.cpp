#include "tests/report/analysis/vibration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace haptic::report {
namespace {

std::vector<double> sine(double amplitude, double hz) {
  std::vector<double> samples;
  for (int i = 0; i < 512; ++i) {
    samples.push_back(3.0 + amplitude * std::sin(2.0 * std::numbers::pi * hz * 1e-3 * i));
  }
  return samples;
}

TEST(Vibration, SineHasItsRmsInBand) {
  for (const double hz : {80.0, 201.3, 450.0}) {
    EXPECT_NEAR(band_rms(sine(0.02, hz)), 0.02 / std::numbers::sqrt2, 1e-4) << hz;
  }
  EXPECT_LT(band_rms(sine(2.0, 3.0)), 1e-3);
  EXPECT_NEAR(band_rms(sine(0.02, 250.0), [](double hz) { return hz / 250.0; }),
              0.02 / std::numbers::sqrt2, 1e-4);
}

TEST(Vibration, ThresholdIsThePublishedPacinianOne) {
  EXPECT_DOUBLE_EQ(vibration_threshold(280.0), 1e-7);
  EXPECT_NEAR(20.0 * std::log10(vibration_threshold(62.5) / vibration_threshold(125.0)), 12.0, 0.1);
  EXPECT_GT(vibration_threshold(500.0), 2e-7);
}

TEST(Vibration, FastForceMovesTheTipsInertia) {
  hw::FingerParameters finger;
  finger.actuator_mass = 0.0;
  // One joint alone, bent by 0: a turns the tip about the PIP by w / (I omega^2).
  const double omega = 2.0 * std::numbers::pi * 2000.0;
  const double expected = 0.040 * 0.01 / (finger.inertia[1] * omega * omega);
  EXPECT_NEAR(tip_compliance(finger, {0.3, 0.0}, {0.0, 0.01}, 2000.0), expected, 0.02 * expected);
}

}  // namespace
}  // namespace haptic::report
