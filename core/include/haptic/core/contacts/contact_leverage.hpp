#pragma once
/// How well the actuators reach a contact (core/METHOD.md#rendering-per-contact).

#include <algorithm>
#include <cmath>

#include "haptic/core/linear/least_squares.hpp"

namespace haptic::core {

/// Leverage below which a contact may be pushed in: rounding decides on which side of 0 it is.
inline constexpr double kLeverage = 0.05;

/// The part of a full push that a contact still allows.
inline double slack_at(double depth, double band, double leverage) noexcept {
  return std::max({0.0, 1.0 - depth / band, 1.0 - leverage / kLeverage});
}

/// Cosine between the way out of a contact and the nearest torque that the actuators can make.
/// `out`: S J^+ of the way out, whose length is 1 in ||.||_W, by the solver's last J.
inline double leverage(const LeastSquares& solver, const VecA& out) noexcept {
  return std::sqrt(out.dot(solver.actuated_square(out)));
}

}  // namespace haptic::core
