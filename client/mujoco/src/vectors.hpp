#pragma once
/// Three numbers in a row, of MuJoCo's arrays and of the client library's.

#include <algorithm>
#include <cstddef>

#include "haptic/client/contact.hpp"

namespace haptic::mujoco {

using client::Vector3;

template <typename Number>
[[nodiscard]] Vector3 vector_at(const Number* first) {
  return {first[0], first[1], first[2]};
}
[[nodiscard]] inline double dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
[[nodiscard]] inline Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
/// a + s b
[[nodiscard]] inline Vector3 add(const Vector3& a, double s, const Vector3& b) {
  return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]};
}

/// Coordinates that the curvature of a contact may have.
inline constexpr std::size_t kMostCurved = 8;
/// Entry of a symmetric matrix, kept as its lower triangle row by row.
[[nodiscard]] constexpr std::size_t triangle(std::size_t a, std::size_t b) {
  return std::max(a, b) * (std::max(a, b) + 1) / 2 + std::min(a, b);
}

}  // namespace haptic::mujoco
