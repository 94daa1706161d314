/// core/METHOD.md#linear-map, core/METHOD.md#block-diagonal-map,
/// core/METHOD.md#null-space-stiffness and core/METHOD.md#change-of-units: identities of the four
/// methods on linear maps.
#include <Eigen/QR>
#include <cmath>
#include <random>

#include "haptic/core/linear/least_squares.hpp"
#include "tests/report/hard_cases/hard_case.hpp"
#include "tests/report/hard_cases/linear_device.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {
namespace {

using core::MatXQ;
using core::RendererKind;
using core::VecA;
using core::VecQ;
using core::VecX;

MatXQ random_matrix(std::mt19937_64& random, int rows, int cols) {
  std::normal_distribution<double> normal;
  MatXQ A(rows, cols);
  for (int i = 0; i < A.size(); ++i) A.data()[i] = normal(random);
  return A;
}

/// Columns orthonormal: no rounding but the solver's own.
MatXQ orthonormal(std::mt19937_64& random, int rows, int cols) {
  const Eigen::MatrixXd A = random_matrix(random, rows, cols);
  const Eigen::MatrixXd Q = Eigen::HouseholderQR<Eigen::MatrixXd>(A).householderQ() *
                            Eigen::MatrixXd::Identity(rows, cols);
  return Q;
}

void linear_map_is_exact(Outcomes& out) {
  std::mt19937_64 random(4);
  double worst_dq = 0.0, worst_tau = 0.0, worst_change = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const auto device = linear_device(orthonormal(random, 6, 4), 2);
    const VecQ q = random_matrix(random, 4, 1), q_star = random_matrix(random, 4, 1);
    const VecA Z_q = (VecA(2) << 1500.0, 3.0).finished();
    VecX x, there;
    MatXQ J;
    if (device->evaluate(q_star, x, J) != core::MapStatus::kOk) continue;
    VecQ dq;
    const VecA tau = force_of(RendererKind::kSubspaceLinear, *device, q, x, Z_q, &dq);
    const double scale = (q_star - q).norm();
    worst_dq = std::max(worst_dq, (dq - (q_star - q)).norm() / scale);
    // Per DoF, in units of its own stiffness.
    const auto off = [&](const VecA& force, const VecQ& by) {
      return (force.cwiseQuotient(Z_q) - by.head(2)).norm() / scale;
    };
    worst_tau = std::max(worst_tau, off(tau, q_star - q));
    const VecQ moved = q + 0.1 * VecQ(random_matrix(random, 4, 1));
    const VecA tau_moved = force_of(RendererKind::kSubspaceLinear, *device, moved, x, Z_q);
    worst_change = std::max(worst_change, off(tau - tau_moved, moved - q));
  }
  out.push_back(
      {"4", "Eq. (8) on a linear f: dq = q* - q to 1e-14, tau_a = Z_q S dq, slope -Z_q",
       said("dq %.1e, tau_a %.1e, slope %.1e (relative)", worst_dq, worst_tau, worst_change),
       worst_dq < 1e-14 && worst_tau < 1e-14 && worst_change < 1e-14});
}

/// Sine of the angle between two vectors.
double angle(const VecA& a, const VecA& b) {
  const VecA across = a - b * (a.dot(b) / b.squaredNorm());
  return across.norm() / a.norm();
}

void block_diagonal_device(Outcomes& out) {
  std::mt19937_64 random(5);
  double same = 0.0, identity = 0.0, aligned = 0.0, generic = 0.0;
  for (int i = 0; i < 500; ++i) {
    MatXQ A = MatXQ::Zero(6, 6);
    const bool isotropic = i % 2 == 0;
    MatXQ J_aa = random_matrix(random, 3, 3);
    if (isotropic) J_aa = 1.7 * orthonormal(random, 3, 3);
    A.topLeftCorner(3, 3) = J_aa;
    A.bottomRightCorner(3, 3) = random_matrix(random, 3, 3);
    const auto device = linear_device(A, 3);
    const VecQ q = random_matrix(random, 6, 1);
    const VecX x = A * VecQ(random_matrix(random, 6, 1));
    const VecA Z_q = VecA::Constant(3, 1500.0);
    VecQ dq;
    const VecA standard = force_of(RendererKind::kStandard, *device, q, x, Z_q);
    const VecA null_space = force_of(RendererKind::kNullSpace, *device, q, x, Z_q);
    const VecA linear = force_of(RendererKind::kSubspaceLinear, *device, q, x, Z_q, &dq);
    const double k = 1500.0 / J_aa.squaredNorm();  // Z_x = Z_q / ||J_a||^2
    const VecA by_hand = k * (J_aa.transpose() * (J_aa * dq.head(3)));
    same = std::max(same, (standard - null_space).norm() / standard.norm());
    identity = std::max(identity, (null_space - by_hand).norm() / by_hand.norm());
    (isotropic ? aligned : generic) =
        std::max(isotropic ? aligned : generic, angle(null_space, linear));
  }
  out.push_back(
      {"5",
       "block-diagonal J: standard = null-space; tau_null = k J_aa^T J_aa dq_a; along (8) iff "
       "J_aa^T J_aa is a multiple of I",
       said("%.1e; %.1e; off by %.1e where it is, up to %.2f where not", same, identity, aligned,
            generic),
       same < 1e-12 && identity < 1e-12 && aligned < 1e-12 && generic > 0.1});
}

/// core/METHOD.md#solver-choice: tau_null = K_null dq_a with K_null = k J_a^T N J_a, N = I - J_n
/// J_n^+.
void null_space_identity(Outcomes& out) {
  std::mt19937_64 random(6);
  double worst = 0.0;
  for (int i = 0; i < 2000; ++i) {
    MatXQ J = random_matrix(random, 6, 4);
    J.col(1) *= std::pow(10.0, i % 7 - 3);  // units: what equilibration is for
    const core::DofLayout layout{true, true, false, false};
    const VecX dx = random_matrix(random, 6, 1);
    core::LeastSquares solver(6, layout);
    solver.solve(J, dx, VecA::Ones(2));
    const Eigen::MatrixXd J_a = J.leftCols(2), J_n = J.rightCols(2);
    const Eigen::MatrixXd Q =
        Eigen::HouseholderQR<Eigen::MatrixXd>(J_n).householderQ() * Eigen::MatrixXd::Identity(6, 2);
    const Eigen::VectorXd in_X = J_a * solver.dq_a();
    const Eigen::VectorXd expected = J_a.transpose() * (in_X - Q * (Q.transpose() * in_X));
    const Eigen::VectorXd got = solver.null_space_force();
    for (int j = 0; j < 2; ++j) {
      worst = std::max(worst, std::abs(got[j] - expected[j]) / (J_a.col(j).norm() * dx.norm()));
    }
  }
  out.push_back({"6", "tau_null = K_null dq_a < 1e-13 relative, 2000 J with mixed units",
                 said("%.1e", worst), worst < 1e-13});
}

/// X in metres or millimetres (all methods), sensed q in rad or deg (all), actuated q in m or mm
/// (the subspace methods): the same force in N.
void units(Outcomes& out) {
  std::mt19937_64 random(14);
  double worst = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const int n_x = i % 3 == 0 ? 2 : 5;  // 2: fewer than dim Q, the rank-deficient path
    const MatXQ A = random_matrix(random, n_x, 3);
    const VecQ q = random_matrix(random, 3, 1);
    const VecX x = A * q + VecX(random_matrix(random, n_x, 1));
    const VecA Z_q = VecA::Constant(1, 1500.0);
    const auto device = linear_device(A, 1);
    for (const RendererKind kind : kMethods) {
      const double tau = force_of(kind, *device, q, x, Z_q)[0];
      const bool subspace =
          kind == RendererKind::kSubspaceLinear || kind == RendererKind::kSubspaceExact;
      // The exact method of a rank-deficient J needs the prior of
      // core/METHOD.md#projection-algorithm, which is no part of this case: q* there depends on
      // where the iteration began.
      if (kind == RendererKind::kSubspaceExact && n_x < 3) continue;
      const VecQ unit = (VecQ(3) << (subspace ? 1e-3 : 1.0), kDegree, 1.0).finished();
      const MatXQ B = 1e3 * A * unit.asDiagonal();
      const auto other = linear_device(B, 1);
      const VecQ q_other = q.cwiseQuotient(unit);
      const VecA Z_other = Z_q * unit[0];
      const double tau_other = force_of(kind, *other, q_other, 1e3 * x, Z_other)[0];
      worst = std::max(worst, std::abs(tau_other - tau) / std::max(std::abs(tau), 1.0));
    }
  }
  out.push_back({"14", "metres or millimetres, rad or deg: the same physical force to 1e-12",
                 said("%.1e relative", worst), worst < 1e-12});
}

}  // namespace

void renderer_cases(Outcomes& out) {
  linear_map_is_exact(out);
  block_diagonal_device(out);
  null_space_identity(out);
  units(out);
}

}  // namespace haptic::report
