#pragma once
/// Bounded vectors and matrices: sized at run time, stored in place. Copying one copies what is
/// used; none of them ever allocates.

#include <Eigen/Core>

namespace haptic::core {

/// Largest device: 6-DoF wrist and five fingers of three joints, with room to spare
/// (core/METHOD.md#metric-and-limits).
inline constexpr int kMaxQ = 24;
/// Largest virtual configuration: 24 points in space (tests/report/STUDY.md#solver-error, the 72 x
/// 24 case).
inline constexpr int kMaxX = 72;

using VecQ = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxQ, 1>;  ///< n_q; m or rad per DoF
using VecA = VecQ;                                                   ///< n_a, actuated DoFs only
using VecX = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxX, 1>;  ///< n_x; unit per coordinate
/// n_x by n_q: columns in the order of q.
using MatXQ = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxX, kMaxQ>;
/// n_a by n_a.
using MatAA = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxQ, kMaxQ>;

}  // namespace haptic::core
