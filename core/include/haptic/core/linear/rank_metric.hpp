#pragma once
/// The metric M on Q that chooses among the dq that J allows if it loses rank
/// (core/METHOD.md#rank-and-prior): without one the choice would depend on the units of q.

#include "haptic/core/model/dof_layout.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

/// The diagonal of M^{-1/2}, n_q, in the order of q. M's actuated block is Z_q (n_a, diagonal;
/// if it is coupled StiffnessCoupling does the rest): only then is the rendered stiffness
/// positive semidefinite if J loses rank. Sensed DoFs are weighted by what they do in X per
/// unit, on the scale of the actuated ones.
[[nodiscard]] VecQ rank_metric_root(const MatXQ& J, const DofLayout& layout,
                                    const VecA& Z_q) noexcept;

}  // namespace haptic::core
