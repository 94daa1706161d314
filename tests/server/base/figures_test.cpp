#include "server/base/figures.hpp"

#include <gtest/gtest.h>

namespace {

using namespace std::chrono_literals;
using haptic::server::milliseconds;

TEST(Figures, MillisecondsAreExactAndPlain) {
  EXPECT_EQ(milliseconds(80ms), "80 ms");
  EXPECT_EQ(milliseconds(12500us), "12.5 ms");
  EXPECT_EQ(milliseconds(1ns), "0.000001 ms");
  EXPECT_EQ(milliseconds(-3ms), "-3 ms");
  EXPECT_EQ(milliseconds(0ns), "0 ms");
  EXPECT_EQ(milliseconds(100s), "100000 ms") << "not 1e+05";
}

TEST(Figures, NanosecondBeyondALimitShows) {
  EXPECT_EQ(milliseconds(180ms + 1ns), "180.000001 ms");
}

}  // namespace
