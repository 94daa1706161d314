#pragma once
/// What the formulas of core/METHOD.md#exact-derivatives need of a matrix of full column rank. In a
/// file of its own, for the decomposition is what costs the compiler its time.

#include <optional>

#include "haptic/core/analysis/displayed_impedance.hpp"

namespace haptic::core {

struct FullColumnRank {
  MatAX inverse{};  ///< A^+, n by n_x
  MatXX off{};      ///< I - A A^+, the projector onto what A does not reach
};

/// Empty where the rank of A, n_x by n, is below n. Columns are scaled to unit length first, so
/// that no choice of units looks like a lost rank.
[[nodiscard]] std::optional<FullColumnRank> full_column_rank(const MatXQ& A);

}  // namespace haptic::core
