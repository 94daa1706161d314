#include "tests/support/loop/pipeline_loop.hpp"

#include <gtest/gtest.h>

namespace haptic::test {
namespace {

TEST(EnergyBook, CountsHeldForceAndLargestSum) {
  const auto one = [](double value) { return core::VecA::Constant(1, value); };
  EnergyBook book(2.0);
  book.add(one(3.0), one(0.010), 0.1);  // 30 mJ given, 2 mJ to the damping
  // 80 mJ taken by the first of two actuators, 10 mJ given by the second.
  book.add(core::VecA{{-4.0, 1.0}}, core::VecA{{0.020, 0.010}}, 0.1);
  EXPECT_NEAR(book.given(), -0.040, 1e-15);
  EXPECT_NEAR(book.net(), 0.030 - 0.002 - 0.070 - 0.010, 1e-15);
  EXPECT_NEAR(book.most_net(), 0.028, 1e-15);
  book.begin_cycle();
  book.add(one(1.0), one(0.001), 0.1);
  EXPECT_NEAR(book.given(), 0.001, 1e-15);
  EXPECT_NEAR(book.most_net(), 0.028, 1e-15);
}

}  // namespace
}  // namespace haptic::test
