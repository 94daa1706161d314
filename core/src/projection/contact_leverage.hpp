#pragma once
/// How well the actuators reach a contact (core/METHOD.md#rendering-per-contact).

#include <cmath>

#include "haptic/core/linear/least_squares.hpp"

namespace haptic::core {

/// Leverage below which a contact may be pushed in: rounding decides on which side of 0 it is.
inline constexpr double kLeverage = 0.05;

/// Cosine between the way out of a contact and the nearest torque that the actuators can make.
/// `out`: S J^+ of the way out, whose length is 1 in ||.||_W, by the solver's last J.
inline double leverage(const LeastSquares& solver, const VecA& out) noexcept {
  return std::sqrt(out.dot(solver.actuated_square(out)));
}

}  // namespace haptic::core
