#include "tests/report/analysis/passivity_radius.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

namespace haptic::core {

namespace {

// Offline, so sized freely: one type of eigenvalue solver is half the compiler's time of two.
using Solver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

/// The symmetric part of -d tau_a/dq_a, n_a by n_a.
std::optional<Eigen::MatrixXd> stiffness_felt(RendererKind kind, const Kinematics& kinematics,
                                              const VecQ& q, const VecX& x,
                                              const RenderingImpedance& impedance) {
  const std::optional<MatAQ> whole = exact_impedance(kind, kinematics, q, x, impedance);
  if (!whole) return std::nullopt;
  const DofLayout& layout = kinematics.layout();
  Eigen::MatrixXd block(layout.n_a(), layout.n_a());
  for (int i = 0; i < layout.n_a(); ++i) block.col(i) = -whole->col(layout.actuated(i));
  return Eigen::MatrixXd(0.5 * (block + block.transpose()));
}

/// Ascending.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& symmetric) {
  return Solver(symmetric, Eigen::EigenvaluesOnly).eigenvalues();
}

}  // namespace

std::optional<PassivityCertificate> passivity_certificate(RendererKind kind,
                                                          const Kinematics& kinematics,
                                                          const VecQ& q, const VecX& x,
                                                          const RenderingImpedance& impedance) {
  const int n_a = kinematics.layout().n_a(), n_x = kinematics.space().n_x();
  VecX x_probe;
  MatXQ J;
  if (kinematics.evaluate(q, x_probe, J) != MapStatus::kOk) return std::nullopt;
  const std::optional<Eigen::MatrixXd> at_rest =
      stiffness_felt(kind, kinematics, q, x_probe, impedance);
  const std::optional<Eigen::MatrixXd> at_x = stiffness_felt(kind, kinematics, q, x, impedance);
  if (!at_rest || !at_x) return std::nullopt;
  const Solver rest(*at_rest);
  if (!(rest.eigenvalues()[0] > 0.0)) return PassivityCertificate{};
  const Eigen::MatrixXd whiten = rest.operatorInverseSqrt();

  // ||sum_j dx_j W L_j W||_2 <= ||.||_F <= ||T||_2 ||dx||, T = [vec(W L_1 W), ...]; for n_a = 1 the
  // three are equal along the worst dx. ||T||_2^2 is the largest eigenvalue of T^T T.
  Eigen::MatrixXd T(n_a * n_a, n_x);
  for (int j = 0; j < n_x; ++j) {
    VecX beside = x_probe;
    beside[j] += 1.0;  // affine in dx: any step is exact; +1 rad stays clear of an angle's seam
    const std::optional<Eigen::MatrixXd> there =
        stiffness_felt(kind, kinematics, q, beside, impedance);
    if (!there) return std::nullopt;
    const Eigen::MatrixXd L = whiten * (*there - *at_rest) * whiten;
    T.col(j) = Eigen::Map<const Eigen::VectorXd>(L.data(), n_a * n_a);
  }
  const double norm = std::sqrt(eigenvalues(T.transpose() * T).tail<1>()[0]);
  return PassivityCertificate{norm > 0.0 ? 1.0 / norm : std::numeric_limits<double>::infinity(),
                              eigenvalues(whiten * *at_x * whiten)[0]};
}

}  // namespace haptic::core
