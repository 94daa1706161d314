#pragma once
/// A Z_q that is not diagonal: Z_q = D C D, with D = diag(sqrt(K)) of the stiffness per actuated
/// DoF, K = diag(Z_q), and C = L L^T of unit diagonal, the coupling. C is the scene's and never
/// changes; a session lowers K. Then Z_q stays positive semidefinite, and lambda_max(B^{-1/2} Z_q
/// B^{-1/2}) never rises, whatever the diagonal B: if the device's damping covers the scene's
/// stiffness, it covers that of every session (core/METHOD.md#sampled-data).

#include <Eigen/Core>

#include "haptic/core/model/dof_layout.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

class StiffnessCoupling {
 public:
  /// From Z_q, n_a by n_a; entry (i, j) in J per unit of DoF i and of DoF j. Throws SceneError: not
  /// square, more than kMaxQ rows, not finite, a diagonal entry that is not above 0, not symmetric,
  /// not positive definite. Allocates; nothing below does.
  explicit StiffnessCoupling(const Eigen::Ref<const Eigen::MatrixXd>& Z_q);

  [[nodiscard]] int n_a() const noexcept { return static_cast<int>(C_.rows()); }
  /// True if nothing is coupled: a scene should then give the stiffness per DoF instead.
  [[nodiscard]] bool is_diagonal() const noexcept;
  /// K of the matrix it was made of, n_a.
  [[nodiscard]] const VecA& scene_stiffness() const noexcept { return stiffness_; }

  /// Z_q = D C D of K (n_a, >= 0).
  [[nodiscard]] MatAA matrix(const VecA& K) const noexcept;

  /// With R = L^T D, Z_q = R^T R. v (n_a) <- L^T v: of v = D d it makes R d, whose squares are
  /// twice the spring's energy.
  void stretch(VecA& v) const noexcept;
  /// v (n_a) <- L^{-T} v: D^{-1} of it makes R^{-1} v.
  void relax(VecA& v) const noexcept;
  /// Row i of L^T, the factor on entry j of v: 0 for j < i.
  [[nodiscard]] double factor(int i, int j) const noexcept { return i <= j ? L_(j, i) : 0.0; }
  /// A (`rows` by n_a, column-major) times L^{-T}, in place.
  void relax_columns(double* A, int rows) const noexcept;
  /// The same of the columns of A (`rows` by n_q) that belong to actuated DoFs; the others stay.
  void relax_columns(double* A, int rows, const DofLayout& layout) const noexcept;

 private:
  template <typename Column>
  void relax_each(int rows, Column column) const noexcept;

  VecA stiffness_{};
  MatAA C_{};
  MatAA L_{};  ///< lower triangle of Cholesky's factor of C
};

}  // namespace haptic::core
