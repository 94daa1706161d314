#pragma once
/// W_x: what counts as near in X (core/METHOD.md#metric-and-limits). Every projection minimises
/// ||x (-) f(q*)||_W, which has no unit: W_ij is in 1 / (unit of x_i times unit of x_j). Renderers
/// see W^{1/2} J and W^{1/2} dx. If X mixes metres and radians there is no natural W and the scene
/// must give one; otherwise the default is the identity.

#include <memory>

#include "haptic/core/types.hpp"

namespace haptic::core {

class TaskMetric {
 public:
  /// The identity, for any n_x.
  TaskMetric() = default;
  /// W = diag(1 / scale_i^2): scale_i (unit of x_i) is the error in x_i that counts as 1. Throws
  /// SceneError unless every scale is finite and > 0.
  [[nodiscard]] static TaskMetric from_scales(const VecX& scale);
  /// Any symmetric positive definite W (n_x by n_x; W_ij in 1 / (unit of x_i times unit of x_j)),
  /// for instance sum_c k_c (J_c^T n_c)(J_c^T n_c)^T + eps I over contact normals. Throws
  /// SceneError, which names the entry; positive definite is smallest eigenvalue > kLeastEigenvalue
  /// once the diagonal is scaled to 1, so that units do not decide.
  [[nodiscard]] static TaskMetric from_matrix(const Eigen::Ref<const Eigen::MatrixXd>& W);

  static constexpr double kLeastEigenvalue = 1e-12;

  [[nodiscard]] bool is_identity() const noexcept { return n_x_ == 0; }
  [[nodiscard]] bool is_diagonal() const noexcept { return upper_ == nullptr; }
  /// 0 for the identity, which fits any.
  [[nodiscard]] int n_x() const noexcept { return n_x_; }
  /// W, n_x by n_x; empty for the identity. Allocates.
  [[nodiscard]] Eigen::MatrixXd matrix() const;

  /// True if W has no entry between the `count` coordinates from `first` on and the others: a block
  /// of the map with these coordinates can be projected alone.
  [[nodiscard]] bool separates(int first, int count) const noexcept;
  /// The metric of coordinates that it separates.
  [[nodiscard]] TaskMetric of(int first, int count) const;
  /// True if the block of these coordinates, which it must separate, is a multiple of the identity:
  /// the nearest x is then the one without a metric.
  [[nodiscard]] bool is_uniform(int first, int count) const noexcept;

  /// v <- W^{1/2} v and J <- W^{1/2} J, with W^{1/2} = L^T of W = L L^T. n_x rows; never allocates.
  void weigh(VecX& v) const noexcept;
  void weigh(MatXQ& J) const noexcept;
  /// W^{1/2} of the argument: the argument itself for the identity, else `scratch`.
  [[nodiscard]] const VecX& weighed(const VecX& v, VecX& scratch) const noexcept;
  [[nodiscard]] const MatXQ& weighed(const MatXQ& J, MatXQ& scratch) const noexcept;
  /// W^{-1} a of a covector a (n_x values in unit of 1 / x_i): the direction along which
  /// a^T x rises most per length in ||.||_W. Never allocates.
  [[nodiscard]] VecX steepest(const VecX& a) const noexcept {
    return steepest(a, 0, static_cast<int>(a.size()));
  }
  /// The same for an a that is 0 but for `count` values from `first` on: n_x multiplications for
  /// each.
  [[nodiscard]] VecX steepest(const VecX& a, int first, int count) const noexcept;

 private:
  void weigh(double* column) const noexcept;

  int n_x_{0};
  VecX diagonal_{};  ///< of W^{1/2}
  /// W^{1/2}, upper triangular, if it is not diagonal. Shared, because copies are made in the loop.
  std::shared_ptr<const Eigen::MatrixXd> upper_{};
  std::shared_ptr<const Eigen::MatrixXd> inverse_{};  ///< W^{-1}, if it is not diagonal
};

}  // namespace haptic::core
