#pragma once
/// The measure of tests/report/STUDY.md#derivatives: the analytic J of a map against central
/// differences.

#include <gtest/gtest.h>

#include <algorithm>

#include "haptic/core/model/kinematics.hpp"

namespace haptic::core {

/// Largest difference over the largest analytic entry, columns scaled by (0.02 m, 1 rad).
inline double jacobian_error(const Kinematics& map, const VecQ& q) {
  constexpr double kStep = 6e-6;  // scaled
  VecX x, x_minus, x_plus;
  MatXQ J;
  EXPECT_EQ(map.evaluate(q, x, J), MapStatus::kOk);
  double error = 0.0, largest = 0.0;
  for (int k = 0; k < q.size(); ++k) {
    const bool length = map.dofs()[static_cast<std::size_t>(k)].unit == Unit::kMetre;
    const double scale = length ? 0.02 : 1.0;
    VecQ minus = q, plus = q;
    minus[k] -= kStep * scale;
    plus[k] += kStep * scale;
    EXPECT_EQ(map.position(minus, x_minus), MapStatus::kOk);
    EXPECT_EQ(map.position(plus, x_plus), MapStatus::kOk);
    const VecX slope = (x_plus - x_minus) / (2.0 * kStep);
    error = std::max(error, (slope - scale * J.col(k)).cwiseAbs().maxCoeff());
    largest = std::max(largest, scale * J.col(k).cwiseAbs().maxCoeff());
  }
  return error / largest;
}

}  // namespace haptic::core
