// Z_q = D C D (core/METHOD.md#actuator-limits and core/METHOD.md#sampled-data; the metric of 4.3).
#include "haptic/core/linear/stiffness_coupling.hpp"

#include <gtest/gtest.h>

#include <string>

#include "haptic/core/error.hpp"
#include "haptic/core/linear/least_squares.hpp"
#include "tests/core/linear/random_matrix.hpp"
#include "tests/support/dense_oracle.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::core {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using samples::gaussian;

/// Symmetric, positive definite, its diagonal over six decades: metres beside radians.
MatrixXd stiffness_of(std::mt19937_64& random, int n) {
  const MatrixXd root = gaussian(random, n, n + 1);
  MatrixXd Z = oracle::product(root, root.transpose());
  std::uniform_real_distribution<double> decades(-1.5, 1.5);
  for (int i = 0; i < n; ++i) {
    const double unit = std::pow(10.0, decades(random));
    Z.row(i) *= unit;
    Z.col(i) *= unit;
  }
  return 0.5 * (Z + Z.transpose());
}

TEST(StiffnessCoupling, ReproducesTheMatrixItWasGiven) {
  std::mt19937_64 random(1);
  for (int n = 1; n <= 6; ++n) {
    const MatrixXd Z = stiffness_of(random, n);
    const StiffnessCoupling coupling(Z);
    EXPECT_EQ(VectorXd(coupling.scene_stiffness()), VectorXd(Z.diagonal()));
    EXPECT_LT((MatrixXd(coupling.matrix(coupling.scene_stiffness())) - Z).norm(), 1e-14 * Z.norm());
    EXPECT_EQ(coupling.is_diagonal(), n == 1);
  }
}

/// A stiffness that a session lowers stays a stiffness, and is nowhere stiffer than what damping
/// has to pay for.
TEST(StiffnessCoupling, LoweringOneNeverRaisesTheStiffest) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> share(0.0, 1.0), damping(0.1, 10.0);
  for (int trial = 0; trial < 500; ++trial) {
    const int n = 2 + trial % 4;
    const MatrixXd Z = stiffness_of(random, n);
    const StiffnessCoupling coupling(Z);
    VecA K = coupling.scene_stiffness(), b(n);
    for (int i = 0; i < n; ++i) {
      K[i] *= trial % 7 == 0 && i == 0 ? 0.0 : share(random);
      b[i] = damping(random);
    }
    const MatrixXd lower = coupling.matrix(K);
    const MatrixXd root = VectorXd(b.cwiseSqrt().cwiseInverse()).asDiagonal();
    const VectorXd before = oracle::singular_values(oracle::product(root * Z, root));
    const MatrixXd relative = oracle::product(root * lower, root);
    EXPECT_LE(oracle::singular_values(relative)[0], before[0] * (1.0 + 1e-12));
    EXPECT_GE(oracle::smallest_eigenvalue(relative), -1e-12 * before[0]);
    EXPECT_LT((lower.diagonal() - VectorXd(K)).cwiseAbs().maxCoeff(), 1e-15 * Z.norm());
  }
}

TEST(StiffnessCoupling, ItsRootMeasuresTheSpringsEnergy) {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + trial % 4;
    const MatrixXd Z = stiffness_of(random, n);
    const StiffnessCoupling coupling(Z);
    const VectorXd d = gaussian(random, n, 1);
    const VecA D_d = coupling.scene_stiffness().cwiseSqrt().cwiseProduct(VecA(d));
    VecA v = D_d;
    coupling.stretch(v);
    EXPECT_NEAR(v.squaredNorm(), d.dot(Z * d), 1e-12 * Z.norm() * d.squaredNorm());
    coupling.relax(v);
    EXPECT_LT((v - D_d).norm(), 1e-9 * D_d.norm()) << "and back";
  }
}

/// B = A L^{-T} is a root of A C^{-1} A^T, the other columns are left alone.
TEST(StiffnessCoupling, RelaxedColumnsMatchTheInverseMetric) {
  std::mt19937_64 random(4);
  const bool actuated[] = {true, false, true, true};
  const DofLayout layout{std::span<const bool>(actuated)};
  for (int trial = 0; trial < 100; ++trial) {
    const MatrixXd Z = stiffness_of(random, 3);
    const VectorXd D = Z.diagonal().cwiseSqrt();
    const MatrixXd C = D.cwiseInverse().asDiagonal() * Z * D.cwiseInverse().asDiagonal();
    const MatrixXd A = gaussian(random, 5, 4);
    MatrixXd mixed = A;
    StiffnessCoupling(Z).relax_columns(mixed.data(), 5, layout);
    EXPECT_EQ(mixed.col(1), A.col(1));
    MatrixXd A_a(5, 3), B(5, 3);
    A_a << A.col(0), A.col(2), A.col(3);
    B << mixed.col(0), mixed.col(2), mixed.col(3);
    const MatrixXd expected =
        oracle::product(oracle::product(A_a, oracle::inverse(C)), A_a.transpose());
    EXPECT_LT((oracle::product(B, B.transpose()) - expected).norm(), 1e-8 * expected.norm());
  }
}

/// core/METHOD.md#rank-and-prior: -Z_q S J^+ J S^T is symmetric and negative semidefinite only with
/// Z_q, all of it, as the metric's actuated block; and dq is the one of least spring energy.
TEST(StiffnessCoupling, LostRankRendersAPassiveStiffness) {
  std::mt19937_64 random(5);
  double worst_of_diagonal = 0.0;
  for (int trial = 0; trial < 300; ++trial) {
    const int n_q = 3 + trial % 3, n_x = n_q - 1 - trial % 2;
    const int n_a = 2 + trial % (n_q - 2);
    bool actuated[kMaxQ]{};
    for (int i = 0; i < n_a; ++i) actuated[n_q - 1 - i] = true;
    const DofLayout layout{std::span<const bool>(actuated, static_cast<std::size_t>(n_q))};
    const MatrixXd Z = stiffness_of(random, n_a);
    const auto coupling = std::make_shared<const StiffnessCoupling>(Z);
    const MatXQ J = gaussian(random, n_x, n_q);
    LeastSquares coupled(n_x, layout, coupling), diagonal(n_x, layout);
    MatrixXd felt(n_a, n_a), as_if_diagonal(n_a, n_a);
    for (int k = 0; k < n_a; ++k) {
      const VecX dx = J.col(layout.actuated(k));
      coupled.solve(J, dx, coupling->scene_stiffness());
      EXPECT_EQ(coupled.status(), ProjectionStatus::kRankDeficient);
      EXPECT_LT((J * coupled.dq() - dx).norm(), 1e-9 * dx.norm());
      felt.col(k) = Z * VectorXd(coupled.dq_a());
      diagonal.solve(J, dx, coupling->scene_stiffness());
      as_if_diagonal.col(k) = Z * VectorXd(diagonal.dq_a());
    }
    EXPECT_LT((felt - felt.transpose()).norm(), 1e-7 * Z.norm());
    EXPECT_GE(oracle::smallest_eigenvalue(0.5 * (felt + felt.transpose())), -1e-8 * Z.norm());
    worst_of_diagonal =
        std::min(worst_of_diagonal,
                 oracle::smallest_eigenvalue(0.5 * (as_if_diagonal + as_if_diagonal.transpose())) /
                     Z.norm());
  }
  EXPECT_LT(worst_of_diagonal, -1e-3) << "the check above can fail";
}

TEST(StiffnessCoupling, RefusesAnInvalidStiffness) {
  const auto matrix = [](double a, double b, double c, double d) {
    return MatrixXd((Eigen::Matrix2d() << a, b, c, d).finished());
  };
  const std::pair<MatrixXd, const char*> cases[] = {
      {matrix(4, 1, 1, 9), "no error"},          {MatrixXd::Ones(2, 3), "2 x 3: must be square"},
      {matrix(4, 1, 1.01, 9), "symmetric"},      {matrix(4, NAN, NAN, 9), "finite"},
      {matrix(4, 0, 0, 0), "entry (1, 1) = 0"},  {matrix(-4, 0, 0, 1), "must be finite and > 0"},
      {matrix(4, 6, 6, 9), "positive definite"}, {matrix(4, 7, 7, 9), "positive definite"}};
  for (const auto& [Z, says] : cases) {
    const std::string text =
        haptic::test::message_of<SceneError>([&Z = Z] { return StiffnessCoupling(Z); });
    EXPECT_NE(text.find(says), std::string::npos) << says << ": " << text;
  }
}

}  // namespace
}  // namespace haptic::core
