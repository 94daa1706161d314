#pragma once
/// The least-squares solution of minimum norm of a matrix whose rank is in doubt: column-pivoted
/// Householder QR to the rank, then the rows of R orthonormalised. For Jacobians that lost rank or
/// have fewer rows than columns; slower than householder.hpp, and used only then.

namespace haptic::core {

/// A: m x n, column-major, leading dimension m, overwritten. b: m, overwritten. y: n, the answer.
/// Columns whose remaining norm falls below threshold times the largest count as dependent. n <=
/// kMaxQ, m <= kMaxX. Returns the rank. Never allocates; A and b must be finite.
int minimum_norm(double* A, double* b, int m, int n, double threshold, double* y) noexcept;

/// f <- f minus its part in the span of the k columns of B (m x k, column-major, overwritten).
/// Columns that depend on the others by less than `threshold` of their norm are left out.
void remove_span(double* B, int m, int k, double threshold, double* f) noexcept;

}  // namespace haptic::core
