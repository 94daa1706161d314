#include "haptic/core/rendering/renderer.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/passivity/direction_guard.hpp"
#include "haptic/core/rendering/per_contact.hpp"
#include "tests/core/linear/random_matrix.hpp"
#include "tests/core/model/sample_maps.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/support/dense_oracle.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using samples::gaussian;
using samples::linear_map;

struct Shape {
  int n_x, n_q, n_a;
};
constexpr Shape kShapes[] = {{2, 2, 1}, {6, 2, 1}, {6, 6, 3}, {7, 3, 2}, {27, 10, 4}, {3, 3, 3}};

/// Eq. (1), (4), (8) with Z_x = z_x W, as they stand in the paper; in every other trial without a
/// metric. tests/report/STUDY.md#linear-map: on a linear map Eq. (6) is Eq. (8).
TEST(Renderers, AgreeWithDenseAlgebra) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> stiffness(10.0, 5000.0);
  for (const Shape& shape : kShapes) {
    for (int trial = 0; trial < 400; ++trial) {
      const MatrixXd A = gaussian(random, shape.n_x, shape.n_q);
      const MatrixXd J_a = A.leftCols(shape.n_a), J_n = A.rightCols(shape.n_q - shape.n_a);
      MatrixXd root = MatrixXd::Identity(shape.n_x, shape.n_x);
      if (trial % 2 != 0) {
        root += 0.4 / std::sqrt(shape.n_x) * gaussian(random, shape.n_x, shape.n_x);
      }
      const MatrixXd W = oracle::product(root.transpose(), root);
      const double condition = oracle::condition(oracle::product(root, A));
      if (condition > 1e3) continue;
      ProjectionSettings settings;
      if (trial % 2 != 0) settings.metric = TaskMetric::from_matrix(W);
      const auto map = linear_map(A, shape.n_a);
      const ProjectionModel model(*map, settings);
      const Instant at(*map, gaussian(random, shape.n_q, 1), gaussian(random, shape.n_x, 1));
      VecA Z_q(shape.n_a);
      for (double& z : Z_q) z = stiffness(random);

      const VectorXd dx = at.dx;
      VectorXd left = dx;  // what sensed DoFs cannot undo
      if (J_n.cols() > 0) left -= J_n * oracle::weighted_least_squares(J_n, W, dx);
      const double z_x = Z_q.mean() / J_a.cwiseProduct(oracle::product(W, J_a)).sum();
      const VectorXd subspace =
          Z_q.cwiseProduct(oracle::weighted_least_squares(A, W, dx).head(shape.n_a));
      const VectorXd want[] = {z_x * (J_a.transpose() * (W * dx)),
                               z_x * (J_a.transpose() * (W * left)), subspace, subspace};
      for (int k = 0; k < 4; ++k) {
        const VecA got = first_force(kEveryRenderer[k], model, at, Z_q);
        ASSERT_LE((got - want[k]).norm(),
                  1e-13 * condition * condition * (want[k].norm() + Z_q.norm()))
            << name(kEveryRenderer[k]);
      }
    }
  }
}

/// tests/report/STUDY.md#block-diagonal-map: 3-DoF force, 6-DoF sensing, block-diagonal J.
TEST(Renderers, BlockDiagonalStandardIsNullSpace) {
  std::mt19937_64 random(5);
  MatrixXd A = MatrixXd::Zero(6, 6);
  A.topLeftCorner(3, 3) = gaussian(random, 3, 3);
  A.bottomRightCorner(3, 3) = gaussian(random, 3, 3);
  const Eigen::Matrix3d J_aa = A.topLeftCorner(3, 3);
  const auto map = linear_map(A, 3);
  const VecA Z_q = VecA::Constant(3, 700.0);
  for (int i = 0; i < 200; ++i) {
    const Instant at(*map, gaussian(random, 6, 1), gaussian(random, 6, 1));
    // tau_null = k J_aa^T J_aa dq_a
    const Eigen::Vector3d dq_a = J_aa.inverse() * at.dx.head(3);
    const VectorXd expected = 700.0 / J_aa.squaredNorm() * J_aa.transpose() * J_aa * dq_a;
    for (const RendererKind kind : {RendererKind::kStandard, RendererKind::kNullSpace}) {
      ASSERT_LT((first_force(kind, *map, at, Z_q) - expected).norm(), 1e-12 * expected.norm());
    }
  }
}

/// tests/report/STUDY.md#null-space-stiffness: tau_null = K_null dq_a with K_null = k J_a^T N J_a,
/// dq_a the deviation of Eq. (8).
TEST(Renderers, NullSpaceIsReweightedSubspaceMethod) {
  std::mt19937_64 random(6);
  const VecA Z_q = VecA::Constant(2, 900.0);
  for (int i = 0; i < 500; ++i) {
    const MatrixXd A = gaussian(random, 6, 4), J_a = A.leftCols(2);
    const auto map = linear_map(A, 2);
    const Instant at(*map, gaussian(random, 4, 1), gaussian(random, 6, 1));
    const VectorXd dq_a = first_force(RendererKind::kSubspaceLinear, *map, at, Z_q) / 900.0;
    const VectorXd off = oracle::off_columns(A.rightCols(2)) * (J_a * dq_a);
    const VectorXd expected = 900.0 / J_a.squaredNorm() * (J_a.transpose() * off);
    ASSERT_LT((first_force(RendererKind::kNullSpace, *map, at, Z_q) - expected).norm(),
              1e-13 * 10 * expected.norm());
  }
}

/// Case by tests/report/STUDY.md#fig-4-finger_sign_change: the error of Eq. (8) against (6) falls
/// with the square of the deviation.
TEST(Renderers, SmallDeviationMakesExactLinearised) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  const VecA Z_q = one(1500.0);
  VecQ q;
  ASSERT_EQ(finger->inverse(two(0.6, 0.7), q), InverseStatus::kExact);
  double previous = 0.0;
  for (double size = 0.01; size > 0.0003; size /= 2.0) {
    const Instant at(*finger, q, two(0.6 - size, 0.7 - 0.5 * size));
    const double error = std::abs(first_force(RendererKind::kSubspaceLinear, *finger, at, Z_q)[0] -
                                  first_force(RendererKind::kSubspaceExact, *finger, at, Z_q)[0]);
    if (previous > 0.0) {
      EXPECT_NEAR(previous / error, 4.0, 0.6) << "size " << size;
    }
    previous = error;
  }
}

TEST(DirectionGuard, WithholdsOnlyForceAwayFromProxy) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  DirectionGuard guard(*finger);
  const VecA Z_q = one(1500.0);
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> mcp(0.0, 1.3), pip(0.0, 1.5);
  int withheld = 0, allowed = 0;
  for (int i = 0; i < 4000; ++i) {
    VecQ q;
    if (finger->inverse(two(mcp(random), pip(random)), q) != InverseStatus::kExact) continue;
    const Instant at(*finger, q, two(mcp(random), pip(random)));
    // tau_x . dx with tau_x = w tau_a, w = (S J^{-1})^T: the work the finger would feel.
    const Eigen::RowVector2d w = Eigen::Matrix2d(at.J).inverse().row(0);
    const double along = w.dot(Eigen::Vector2d(at.dx));
    for (const RendererKind kind : kEveryRenderer) {
      const VecA tau = first_force(kind, *finger, at, Z_q);
      if (std::abs(tau[0] * along) < 1e-9) continue;
      bool expected = tau[0] * along > 0.0;
      if (kind == RendererKind::kSubspaceLinear || kind == RendererKind::kNullSpace) {
        ASSERT_TRUE(expected)
            << name(kind) << " is never away from the proxy (core/METHOD.md#forces-at-the-finger)";
      }
      // Nor into a joint's contact, if both joints are displaced the same way.
      for (int k = 0; k < 2 && at.dx[0] * at.dx[1] > 0.0; ++k) {
        if (std::abs(at.dx[k]) <= contact_band(*finger)) continue;
        if (std::abs(w[k]) < 0.05 * w.norm()) continue;  // hardly any leverage
        expected = expected && tau[0] * w[k] * at.dx[k] >= 0.0;
      }
      ASSERT_EQ(guard.share(at.probe(), at.dx, tau) > 0.0, expected) << name(kind);
      (expected ? allowed : withheld) += 1;
    }
  }
  EXPECT_GT(withheld, 100);
  EXPECT_GT(allowed, 1000);
}

/// A contact across what the actuator can push is decided by rounding, so it is no reason.
TEST(DirectionGuard, IgnoresContactsBeyondTheActuator) {
  std::mt19937_64 random(12);
  std::normal_distribution<double> normal;
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  DirectionGuard guard(*finger);
  for (int i = 0; i < 500; ++i) {
    const VecX x = two(0.5 + 0.001 * i, 0.7);
    VecQ q;
    ASSERT_EQ(finger->inverse(x, q), InverseStatus::kExact);
    const Instant at(*finger, q, x);
    const Eigen::Vector2d w = Eigen::Matrix2d(at.J).inverse().row(0).transpose();
    Contacts contacts;
    contacts.into.resize(2, 2);
    contacts.into.col(0) = -w.normalized();
    contacts.into.col(1) = Eigen::Vector2d(-w[1], w[0]).normalized() + 1e-3 * normal(random) * w;
    contacts.depth = PlaneSet::Offsets::Constant(2, 0.1);
    const VecX dx = 0.01 * w.normalized();
    ASSERT_TRUE(guard.share(at.probe({&contacts}), dx, one(1.0)) > 0.0) << i;
    ASSERT_FALSE(guard.share(at.probe({&contacts}), dx, one(-1.0)) > 0.0) << i;
  }
}

}  // namespace
}  // namespace haptic::core
