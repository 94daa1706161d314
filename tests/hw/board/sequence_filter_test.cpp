#include "hw/board/sequence_filter.hpp"

#include <gtest/gtest.h>

namespace haptic::hw::board {
namespace {

TEST(SequenceFilter, SkippedNumbersAreCounted) {
  SequenceFilter filter;
  filter.restart(0xFFFFFFFEU);
  EXPECT_TRUE(filter.accept(0xFFFFFFFFU));
  EXPECT_TRUE(filter.accept(0));  // wraps
  EXPECT_EQ(filter.lost(), 0U);
  EXPECT_FALSE(filter.accept(0));  // repeated
  EXPECT_TRUE(filter.accept(4));
  EXPECT_EQ(filter.lost(), 3U);
  EXPECT_FALSE(filter.accept(2));  // late
  EXPECT_FALSE(filter.accept(4U + 0x80000000U));
  EXPECT_EQ(filter.lost(), 3U);
}

}  // namespace
}  // namespace haptic::hw::board
