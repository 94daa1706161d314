#pragma once
/// Pseudo-inverse of a matrix of full column rank, for core/METHOD.md#exact-derivatives. It
/// allocates.

#include <optional>

#include "haptic/core/types.hpp"

namespace haptic::core {

using MatAX = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxQ, kMaxX>;
using MatXX = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxX, kMaxX>;

struct FullColumnRank {
  MatAX inverse{};  ///< A^+, n by n_x
  MatXX off{};      ///< I - A A^+, the projector onto what A does not reach
};

/// Empty if the rank of A, n_x by n, is below n. Columns are scaled to unit length first, so
/// that no choice of units looks like a lost rank.
[[nodiscard]] std::optional<FullColumnRank> full_column_rank(const MatXQ& A);

}  // namespace haptic::core
