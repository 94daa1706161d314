#pragma once
/// The measure of tests/report/STUDY.md#derivatives: analytic derivatives of a map against central
/// differences.

#include <gtest/gtest.h>

#include <algorithm>

#include "haptic/core/model/kinematics.hpp"

namespace haptic::core {

/// Largest difference over the largest analytic entry, columns scaled by (0.02 m, 1 rad).
struct DerivativeErrors {
  double J{0.0};
  double dJ{0.0};
};

inline DerivativeErrors derivative_errors(const Kinematics& map, const VecQ& q) {
  constexpr double kStep = 6e-6;  // scaled
  const int n_q = map.layout().n_q();
  VecX x, x_minus, x_plus;
  MatXQ J, J_minus, J_plus, J_k;
  EXPECT_EQ(map.evaluate(q, x, J), MapStatus::kOk);
  const auto scale = [&](int k) {
    return map.dofs()[static_cast<std::size_t>(k)].unit == Unit::kMetre ? 0.02 : 1.0;
  };
  double J_error = 0.0, J_largest = 0.0, dJ_error = 0.0, dJ_largest = 0.0;
  for (int k = 0; k < n_q; ++k) {
    VecQ minus = q, plus = q;
    minus[k] -= kStep * scale(k);
    plus[k] += kStep * scale(k);
    EXPECT_EQ(map.evaluate(minus, x_minus, J_minus), MapStatus::kOk);
    EXPECT_EQ(map.evaluate(plus, x_plus, J_plus), MapStatus::kOk);
    EXPECT_EQ(map.second_order(q, k, J_k), MapStatus::kOk);
    EXPECT_EQ(J_k.rows(), map.space().n_x());
    EXPECT_EQ(J_k.cols(), n_q);
    const VecX slope = (x_plus - x_minus) / (2.0 * kStep);
    J_error = std::max(J_error, (slope - scale(k) * J.col(k)).cwiseAbs().maxCoeff());
    J_largest = std::max(J_largest, scale(k) * J.col(k).cwiseAbs().maxCoeff());
    for (int i = 0; i < n_q; ++i) {
      const VecX bend = (J_plus.col(i) - J_minus.col(i)) / (2.0 * kStep) * scale(i);
      const VecX analytic = scale(k) * scale(i) * J_k.col(i);
      dJ_error = std::max(dJ_error, (bend - analytic).cwiseAbs().maxCoeff());
      dJ_largest = std::max(dJ_largest, analytic.cwiseAbs().maxCoeff());
    }
  }
  // A map without curvature is measured against its J.
  return {J_error / J_largest, dJ_error / std::max(dJ_largest, 0.01 * J_largest)};
}

}  // namespace haptic::core
