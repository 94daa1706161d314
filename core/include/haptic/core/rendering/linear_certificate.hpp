#pragma once
/// The certificate of the linearised method, live (core/METHOD.md#exact-derivatives): does the
/// force of Eq. (8) oppose every motion of the actuated DoFs, including the change of J? Eq. (9)
/// cannot say: it takes J as constant and always answers -Z_q. The margin is necessary for
/// passivity, not sufficient.
///
/// Per independent block, with the proxy held where it is in this tick:
///   margin = lambda_min sym( I + R (S B S^T) R^{-1} ),   Z_q = R^T R (diagonal: R = Z_q^{1/2}),
///   B e_k  = J^+ J_,k dq - (J^T J)^{-1} J_,k^T r = -(d_k dq + e_k),   r = dx - J dq,
/// where J, J_,k = dJ/dq_k and dx are weighed by W_x^{1/2}. For one actuated DoF it is 1 + g.dx. 1
/// at dx = 0; not above 0: the spring pushes along with some motion. The same number as the margin
/// of the study's passivity_certificate(), which is offline and knows no W_x.

#include <memory>
#include <vector>

#include "haptic/core/linear/householder.hpp"
#include "haptic/core/rendering/certificate.hpp"
#include "haptic/core/rendering/projection.hpp"
#include "haptic/core/rendering/projection_model.hpp"

namespace haptic::core {

class LinearCertificate {
 public:
  /// The model's kinematics must outlive this. Throws SceneError if it has a prior: Eq. (8) is
  /// then another function of q.
  explicit LinearCertificate(const ProjectionModel& model);

  /// dx = x (-) x_probe, n_x; stiffness: diag(Z_q), n_a; probe.J of the blocks that dx displaces. A
  /// block without a margin ends it, because the margins of the others alone would say too much.
  /// Never allocates, locks, throws.
  [[nodiscard]] Certificate at(const Probe& probe, const VecX& dx, const VecA& stiffness) noexcept;

 private:
  struct Block {
    MapBlock at{};
    TaskMetric metric{};
    HouseholderKernel kernel{};
  };
  [[nodiscard]] CertificateStatus judge(const Block& block, const Probe& probe, const VecX& dx,
                                        const VecA& stiffness, double& margin) noexcept;
  /// y = J_^+ b, n_q, and R in A_; false if J_ has not full column rank.
  [[nodiscard]] bool solve(const Block& block, const VecX& b, VecQ& y) noexcept;
  /// y -= (J_^T J_)^{-1} J_k_^T r_, by the R of the last solve().
  void take_off_residual(const Block& block, VecQ& y) noexcept;
  /// M_ = I + the symmetric part of R (S B S^T) R^{-1} if R is not diagonal.
  void couple(const StiffnessCoupling& coupling) noexcept;
  /// Of M_; false if it is not finite.
  [[nodiscard]] bool smallest_eigenvalue(double& value) const noexcept;

  std::vector<Block> blocks_{};
  std::shared_ptr<const StiffnessCoupling> coupling_{};
  VecQ q_{}, dq_{}, column_{};
  VecX r_{}, turned_{};
  MatXQ J_{}, J_k_{};  ///< weighed
  MatAA M_{};          ///< I + R (S B S^T) R^{-1}, symmetric part
  MatAA turn_{};       ///< D (S B S^T) D^{-1}, if Z_q is coupled
  double A_[kMaxX * kMaxQ], b_[kMaxX], column_norm2_[kMaxQ], inverse_diagonal_[kMaxQ];
};

}  // namespace haptic::core
