#include "tests/support/loop/local_laws.hpp"

#include <gtest/gtest.h>

#include "tests/support/loop/pipeline_loop.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::test {
namespace {

using core::VecX;

Frame frame(double seen, const VecX& x_probe, const VecX& x) {
  Frame f;
  f.seen_s = seen;
  f.x_probe = x_probe;
  f.x = x;
  return f;
}

TEST(LocalLaw, AHeldDeviationMovesWithTheProbe) {
  const Frame sample = frame(0.0, two(0.5, 0.2), two(0.3, 0.2));
  const VecX now = two(0.6, 0.1);
  const VecX x = held_deviation()({sample, sample, 0.01, now, now});
  EXPECT_NEAR((x - now - two(-0.2, 0.0)).norm(), 0.0, 1e-15);
}

TEST(LocalLaw, ExtrapolationGoesOnForOnePeriodAtMost) {
  const Frame first = frame(1.00, two(0, 0), two(0.10, 0.20));
  const Frame second = frame(1.02, two(0, 0), two(0.14, 0.18));
  const VecX now = two(0, 0);
  const auto at = [&](double since) { return extrapolated()({second, first, since, now, now}); };
  EXPECT_EQ(at(0.0), second.x);
  EXPECT_NEAR((at(0.01) - two(0.16, 0.17)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((at(0.02) - two(0.18, 0.16)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((at(0.10) - at(0.02)).norm(), 0.0, 1e-14);
  EXPECT_EQ(extrapolated()({first, first, 0.1, now, now}), first.x) << "one sample has no rate";
}

TEST(EnergyBook, CountsTheHeldForceExactlyAndItsLargestSum) {
  EnergyBook book(2.0);
  book.add(3.0, 0.010, 0.1);   // 30 mJ given, 2 mJ to the damping
  book.add(-4.0, 0.020, 0.1);  // 80 mJ taken
  EXPECT_NEAR(book.given(), -0.050, 1e-15);
  EXPECT_NEAR(book.net(), 0.030 - 0.002 - 0.080 - 0.008, 1e-15);
  EXPECT_NEAR(book.most_net(), 0.028, 1e-15);
  book.begin_cycle();
  book.add(1.0, 0.001, 0.1);
  EXPECT_NEAR(book.given(), 0.001, 1e-15);
  EXPECT_NEAR(book.most_net(), 0.028, 1e-15);
}

}  // namespace
}  // namespace haptic::test
