/// core/METHOD.md#condition-sweep, core/METHOD.md#large-residual, core/METHOD.md#rank-loss and
/// core/METHOD.md#unequal-stiffness: conditioning and loss of rank.
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "haptic/core/linear/householder.hpp"
#include "haptic/core/linear/least_squares.hpp"
#include "tests/core/linear/random_matrix.hpp"
#include "tests/report/hard_cases/hard_case.hpp"

namespace haptic::report {
namespace {

using core::MatXQ;
using core::VecA;
using core::VecQ;
using core::VecX;
using core::samples::gaussian;
using core::samples::orthonormal;
using core::samples::with_condition;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kEps = std::numeric_limits<double>::epsilon();

/// The kernel alone, with back substitution and no doubt about the rank.
VectorXd by_kernel(const MatrixXd& A, const VectorXd& b) {
  const int m = static_cast<int>(A.rows()), n = static_cast<int>(A.cols());
  const core::HouseholderKernel kernel = core::householder_kernel(m, n);
  MatrixXd R = A;
  VectorXd rotated = b, norms(n), inverse_diagonal(n), y(n);
  kernel.factor(m, n, R.data(), rotated.data(), norms.data(), inverse_diagonal.data());
  kernel.back_substitute(m, n, R.data(), rotated.data(), inverse_diagonal.data(), y.data());
  return y;
}

void conditioning(Outcomes& out) {
  std::mt19937_64 random(10);
  double worst = 0.0, quiet_at = 0.0, flagged_at = HUGE_VAL;
  bool finite = true;
  for (int exponent = 0; exponent <= 16; ++exponent) {
    const double cond = std::pow(10.0, exponent);
    for (int i = 0; i < 40; ++i) {
      const MatrixXd A = with_condition(random, 6, 6, cond);
      const VectorXd solution = gaussian(random, 6, 1), b = A * solution;
      const VectorXd found = by_kernel(A, b);
      worst = std::max(worst, (found - solution).norm() / solution.norm() / (kEps * cond));
      core::LeastSquares solver(6, {true, true, false, false, false, false});
      solver.solve(A, b, VecA::Ones(2));
      finite = finite && solver.dq().allFinite() && found.allFinite();
      if (solver.status() == core::ProjectionStatus::kExact) {
        quiet_at = std::max(quiet_at, cond);
      } else {
        flagged_at = std::min(flagged_at, cond);
      }
    }
  }
  out.push_back(
      {"10", "6x6, cond 1e0..1e16: QR error < 10 eps cond; no NaN; flagged above 1e8, not below",
       said("at most %.1f eps cond; %s; lowest flagged %.0e, highest not flagged %.0e", worst,
            finite ? "all finite" : "not finite", flagged_at, quiet_at),
       worst < 10.0 && finite && flagged_at >= 1e8 && quiet_at <= 1e8});
}

void large_residual(Outcomes& out) {
  std::mt19937_64 random(11);
  double qr = 0.0, normal_equations = 0.0;
  for (int i = 0; i < 40; ++i) {
    const MatrixXd Q = orthonormal(random, 72, 72);
    VectorXd s(24);
    for (int k = 0; k < 24; ++k) s[k] = std::pow(1e4, -k / 23.0);
    const MatrixXd A = Q.leftCols(24) * s.asDiagonal() * orthonormal(random, 24, 24).transpose();
    const VectorXd solution = gaussian(random, 24, 1);
    VectorXd off = Q.rightCols(48) * gaussian(random, 48, 1);
    const VectorXd inside = A * solution;
    off *= 0.1 * inside.norm() / off.norm();
    const VectorXd b = inside + off;
    std::array<bool, 24> actuated{};
    for (int k = 0; k < 12; ++k) actuated[static_cast<std::size_t>(k)] = true;
    core::LeastSquares solver(72, core::DofLayout(std::span<const bool>(actuated)));
    solver.solve(A, b, VecA::Ones(12));
    qr = std::max(qr, (solver.dq() - solution).norm() / solution.norm());
    const VectorXd by_normal = (A.transpose() * A).llt().solve(A.transpose() * b);
    normal_equations = std::max(normal_equations, (by_normal - solution).norm() / solution.norm());
  }
  out.push_back({"11", "72x24, cond 1e4, 10 % residual: QR < 1e-10 (normal equations < 1e-8)",
                 said("QR %.1e, normal equations %.1e", qr, normal_equations), qr < 1e-10});
}

/// M of core/METHOD.md#rank-and-prior: actuated block Z_q, sensed DoFs by what they move in X.
VectorXd metric(const MatrixXd& J, int n_a, const VecA& Z_q) {
  VectorXd M(J.cols());
  double z_x = 0.0;
  int counted = 0;
  for (int i = 0; i < n_a; ++i) {
    M[i] = Z_q[i];
    if (J.col(i).squaredNorm() > 0.0) {
      z_x += Z_q[i] / J.col(i).squaredNorm();
      ++counted;
    }
  }
  z_x /= counted;
  for (Eigen::Index i = n_a; i < J.cols(); ++i) {
    M[i] = J.col(i).squaredNorm() > 0.0 ? z_x * J.col(i).squaredNorm() : 1.0;
  }
  return M;
}

void rank_loss(Outcomes& out) {
  std::mt19937_64 random(12);
  double worst_dq = 0.0, worst_image = 0.0;
  bool finite = true, told = true;
  for (int i = 0; i < 1000; ++i) {
    const int n_x = i % 3 == 2 ? 2 : 6;  // dim X < dim Q
    MatrixXd J = gaussian(random, n_x, 4);
    if (i % 3 == 0) J.col(i % 2 == 0 ? 0 : 3).setZero();
    if (i % 3 == 1) J.col(3) = J.col(i % 2 == 0 ? 0 : 2);
    const VecA Z_q = (VecA(2) << 1.0, 50.0).finished();
    const VectorXd dx = gaussian(random, n_x, 1);
    core::LeastSquares solver(n_x, {true, true, false, false});
    solver.solve(J, dx, Z_q);
    const VectorXd root = metric(J, 2, Z_q).cwiseSqrt().cwiseInverse();
    Eigen::JacobiSVD<MatrixXd> svd(J * root.asDiagonal(),
                                   Eigen::ComputeThinU | Eigen::ComputeThinV);
    svd.setThreshold(1e-8);
    const VectorXd expected = root.cwiseProduct(VectorXd(svd.solve(dx)));
    const VectorXd got = solver.dq();
    finite = finite && got.allFinite();
    told = told && solver.status() == core::ProjectionStatus::kRankDeficient;
    worst_dq = std::max(worst_dq, (got - expected).norm() / expected.norm());
    worst_image = std::max(worst_image, (J * got - J * expected).norm() / dx.norm());
  }
  out.push_back({"12",
                 "zero column, duplicate column, dim X < dim Q: finite, min-M-norm and J dq to "
                 "1e-12, said so",
                 said("dq %.1e, J dq %.1e; %s, %s", worst_dq, worst_image,
                      finite ? "finite" : "not finite", told ? "rank-deficient" : "not told"),
                 worst_dq < 1e-12 && worst_image < 1e-12 && finite && told});
}

/// Smallest eigenvalue of the symmetric part of Z_q S J_M^+ J S^T, and the largest.
struct Range {
  double smallest{0.0}, largest{0.0};
};
Range felt(const MatrixXd& projector, const VecA& Z_q) {
  const Eigen::Matrix2d L = Z_q.asDiagonal() * projector.topLeftCorner(2, 2);
  const Eigen::Vector2d e =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(0.5 * (L + L.transpose())).eigenvalues();
  return {e[0], e[1]};
}

void anisotropic_stiffness(Outcomes& out) {
  MatXQ J(2, 4);
  J << .125730, -.132105, .640423, .104900, -.535669, .361595, 1.304000, .947081;
  constexpr double kRatios[] = {1, 10, 100, 1000}, kEuclidean[] = {.0013, -.60, -7.7, -79};
  bool passed = true;
  std::string got = "M = I:";
  double lowest = HUGE_VAL;
  for (int i = 0; i < 4; ++i) {
    const VecA Z_q = (VecA(2) << 1.0, kRatios[i]).finished();
    const MatrixXd pinv = MatrixXd(J).completeOrthogonalDecomposition().pseudoInverse();
    const Range euclidean = felt(pinv * J, Z_q);
    got += said(" %.2g", euclidean.smallest);
    passed = passed && std::abs(euclidean.smallest - kEuclidean[i]) <=
                           0.06 * std::abs(kEuclidean[i]);  // two digits are published
    MatrixXd projector(4, 4);
    core::LeastSquares solver(2, {true, true, false, false});
    for (int k = 0; k < 4; ++k) {
      solver.solve(J, J.col(k), Z_q);
      projector.col(k) = solver.dq();
    }
    const Range ours = felt(projector, Z_q);
    lowest = std::min(lowest, ours.smallest / ours.largest);
  }
  out.push_back({"13",
                 "J 2x4, Z_q = diag(1,r): smallest eigenvalue with M = I .0013 -.60 -7.7 -79; "
                 "with the actuated block Z_q >= -1e-12 lambda_max",
                 got + said("; ours %.1e lambda_max", lowest), passed && lowest >= -1e-12});
}

}  // namespace

void rank_cases(Outcomes& out) {
  conditioning(out);
  large_residual(out);
  rank_loss(out);
  anisotropic_stiffness(out);
}

}  // namespace haptic::report
