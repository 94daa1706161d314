#include "tests/report/analysis/cycle_energy.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace haptic::core {
namespace {

TEST(CycleWork, IsTheLoopsSignedArea) {
  // q = (0,1,1,0), tau = (0,0,1,1): a unit square run so that force and motion meet at tau = 0
  // on the way out and tau = 1 on the way back: work -1.
  const std::vector<double> q{0, 1, 1, 0}, tau{0, 0, 1, 1};
  EXPECT_DOUBLE_EQ(cycle_work(q, tau), -1.0);
  EXPECT_DOUBLE_EQ(cycle_work(q, tau, Direction::kReversed), 1.0);
}

TEST(RunningEnergy, FallsByWhatASpringReturns) {
  // tau = -q from q = 1: towards 0 the spring gives 1/2, beyond it takes again.
  const std::vector<double> q{1, 0.5, 0, -0.5}, tau{-1, -0.5, 0, 0.5};
  EXPECT_DOUBLE_EQ(lowest_running_energy(q, tau), -0.5);
  EXPECT_EQ(lowest_running_energy({}, {}), 0.0);
}

}  // namespace
}  // namespace haptic::core
