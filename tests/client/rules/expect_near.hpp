#pragma once
/// Lists that should agree.

#include <gtest/gtest.h>

#include <vector>

namespace haptic::client {

inline void expect_near(const std::vector<double>& a, const std::vector<double>& b, double within) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], within) << i;
}

}  // namespace haptic::client
