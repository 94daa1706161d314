#pragma once
/// The least-squares solution of minimum norm of a matrix whose rank is in doubt: column-pivoted
/// Householder QR to the rank, then the rows of R orthonormalised. For Jacobians that lost rank or
/// have fewer rows than columns; slower than householder.hpp, and used only then. Also the metric M
/// on Q that chooses among the dq that J allows if it loses rank (core/METHOD.md#rank-and-prior):
/// without one the choice would depend on the units of q.

#include "haptic/core/model/dof_layout.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

/// A: m x n, column-major, leading dimension m, overwritten. b: m, overwritten. y: n, the answer.
/// Columns whose remaining norm falls below threshold times the largest count as dependent. n <=
/// kMaxQ, m <= kMaxX. Returns the rank. Never allocates; A and b must be finite.
int minimum_norm(double* A, double* b, int m, int n, double threshold, double* y) noexcept;

/// f <- f minus its part in the span of the k columns of B (m x k, column-major, overwritten).
/// Columns that depend on the others by less than `threshold` of their norm are left out.
void remove_span(double* B, int m, int k, double threshold, double* f) noexcept;

/// The diagonal of M^{-1/2}, n_q, in the order of q. M's actuated block is Z_q (n_a, diagonal;
/// if it is coupled StiffnessCoupling does the rest): only then is the rendered stiffness
/// positive semidefinite if J loses rank. Sensed DoFs are weighted by what they do in X per
/// unit, on the scale of the actuated ones.
[[nodiscard]] VecQ rank_metric_root(const MatXQ& J, const DofLayout& layout,
                                    const VecA& Z_q) noexcept;

}  // namespace haptic::core
