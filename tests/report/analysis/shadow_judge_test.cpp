#include "tests/report/analysis/shadow_judge.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace haptic::report {
namespace {

using core::VecA;

/// Presses of one sine a second, 10 N deep, and as long in free space; what is felt comes
/// `late` s later.
ShadowFigures presses(double late) {
  const auto force = [](double t) { return 10.0 * std::max(0.0, std::sin(2.0 * M_PI * t)); };
  ShadowJudge judge;
  for (int k = 1; k <= 4000; ++k) {
    const double t = 1e-3 * k, shadow = force(t);
    judge.add({.felt = VecA::Constant(1, force(t - late)),
               .shadow = VecA::Constant(1, shadow),
               .elastic = VecA::Constant(1, force(t - late)),
               .touching = shadow > 0.0,
               .clearance = -0.2 * std::sin(2.0 * M_PI * t)});
  }
  return judge.figures();
}

TEST(ShadowJudge, DelayIsAnError) {
  // sin(w t) - sin(w (t - d)) = 2 sin(w d / 2) cos(w (t - d / 2)): rms 2 sin(w d / 2) / sqrt 2,
  // but at the beginning, where nothing is felt for d.
  for (const double late : {0.0, 0.005, 0.010, 0.020}) {
    const ShadowFigures f = presses(late);
    const double expected = 10.0 * M_SQRT2 * std::sin(M_PI * late);
    EXPECT_NEAR(f.error, expected, 0.03 * expected) << late;
    EXPECT_NEAR(f.percent(), 10.0 * f.error, 1e-9);
    EXPECT_EQ(f.onset, std::lround(1e3 * late));
    EXPECT_EQ(f.drag > 0.0, late > 0.0) << "what is felt late is felt outside too";
    EXPECT_EQ(f.contacts, 4);
    EXPECT_NEAR(f.peak, 10.0, 1e-9);
  }
}

TEST(ShadowJudge, CountsTicksWithinTheBound) {
  ShadowJudge judge;
  for (int k = 0; k < 8; ++k) {  // errors of 0, 1, ... 7 N; the first six have a bound of 4 N
    judge.add({.felt = VecA::Constant(1, -k),
               .shadow = VecA::Zero(1),
               .elastic = VecA::Zero(1),
               .touching = k > 0,
               .bound = k < 6 ? VecA(VecA::Constant(1, 4.0)) : VecA()});
  }
  const ShadowFigures f = judge.figures();
  EXPECT_NEAR(f.kept, 5.0 / 6.0, 1e-12);
  EXPECT_NEAR(f.bounded, 5.0 / 7.0, 1e-12);
  EXPECT_EQ(f.error_median, 3.0);
  EXPECT_EQ(f.bound_median, 4.0);
}

}  // namespace
}  // namespace haptic::report
