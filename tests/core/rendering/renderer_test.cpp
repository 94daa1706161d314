#include "haptic/core/rendering/renderer.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/linear.hpp"
#include "haptic/core/passivity/direction_guard.hpp"
#include "haptic/core/rendering/per_contact.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::core {
namespace {

std::unique_ptr<Kinematics> linear_map(const Eigen::MatrixXd& A, int n_a, double box = 1e6) {
  LinearMap map;
  for (int i = 0; i < A.cols(); ++i) {
    map.dofs.push_back({"q" + std::to_string(i), Unit::kMetre, i < n_a, -box, box});
  }
  for (int i = 0; i < A.rows(); ++i) {
    map.coordinates.push_back({"x" + std::to_string(i), Unit::kMetre, CoordinateKind::kLinear});
  }
  map.A = A;
  return make_linear(map);
}

/// tau_a = Z_q S (q* - q) of a renderer at q for proxy x.
VecA force(RendererKind kind, const Kinematics& map, const VecQ& q, const VecX& x, const VecA& Z_q,
           Projection* projection = nullptr) {
  VecX x_probe, dx;
  MatXQ J;
  EXPECT_EQ(map.evaluate(q, x_probe, J), MapStatus::kOk);
  map.space().difference(x, x_probe, dx);
  Renderer renderer(kind, map);
  Projection out;
  renderer.project(Probe{q, x_probe, J}, x, dx, Z_q, true, out);
  if (projection != nullptr) *projection = out;
  return Z_q.cwiseProduct(map.layout().select(out.q_star - q));
}

Eigen::MatrixXd random_matrix(std::mt19937_64& random, int rows, int columns) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd A(rows, columns);
  for (int i = 0; i < A.size(); ++i) A.data()[i] = normal(random);
  return A;
}

struct Shape {
  int n_x, n_q, n_a;
};
constexpr Shape kShapes[] = {{2, 2, 1}, {6, 2, 1}, {6, 6, 3}, {7, 3, 2}, {27, 10, 4}, {3, 3, 3}};

/// Eq. (1), (4), (8) written out with Eigen's decompositions, as they stand in the paper.
TEST(Renderers, AgreeWithDenseAlgebra) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> stiffness(10.0, 5000.0);
  for (const Shape& shape : kShapes) {
    for (int trial = 0; trial < 400; ++trial) {
      const Eigen::MatrixXd A = random_matrix(random, shape.n_x, shape.n_q);
      const double condition = oracle::condition(A);
      if (condition > 1e3) continue;
      const auto map = linear_map(A, shape.n_a);
      const VecQ q = random_matrix(random, shape.n_q, 1);
      const VecX x = random_matrix(random, shape.n_x, 1);
      VecA Z_q(shape.n_a);
      for (int i = 0; i < shape.n_a; ++i) Z_q[i] = stiffness(random);

      const Eigen::VectorXd dx = x - A * q;
      const Eigen::MatrixXd J_a = A.leftCols(shape.n_a), J_n = A.rightCols(shape.n_q - shape.n_a);
      const double z_x = Z_q.mean() / J_a.squaredNorm();
      const Eigen::VectorXd standard = J_a.transpose() * z_x * dx;
      const Eigen::VectorXd f = oracle::off_columns(J_n) * dx;
      const Eigen::VectorXd null_space = J_a.transpose() * f * z_x;
      const Eigen::VectorXd dq = oracle::least_squares(A, dx);
      const Eigen::VectorXd subspace = Z_q.cwiseProduct(dq.head(shape.n_a));

      const double tolerance = 1e-13 * condition * condition;
      const auto near = [&](const VecA& got, const Eigen::VectorXd& want) {
        return (got - want).norm() <= tolerance * (want.norm() + Z_q.norm());
      };
      EXPECT_TRUE(near(force(RendererKind::kStandard, *map, q, x, Z_q), standard));
      EXPECT_TRUE(near(force(RendererKind::kNullSpace, *map, q, x, Z_q), null_space));
      EXPECT_TRUE(near(force(RendererKind::kSubspaceLinear, *map, q, x, Z_q), subspace));
      // tests/report/STUDY.md#linear-map: on a linear map Eq. (6) is Eq. (8).
      EXPECT_TRUE(near(force(RendererKind::kSubspaceExact, *map, q, x, Z_q), subspace));
    }
  }
}

/// tests/report/STUDY.md#block-diagonal-map: 3-DoF force, 6-DoF sensing, block-diagonal J.
TEST(Renderers, BlockDiagonalStandardIsNullSpace) {
  std::mt19937_64 random(5);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(6, 6);
  A.topLeftCorner(3, 3) = random_matrix(random, 3, 3);
  A.bottomRightCorner(3, 3) = random_matrix(random, 3, 3);
  const auto map = linear_map(A, 3);
  const VecA Z_q = VecA::Constant(3, 700.0);
  for (int i = 0; i < 200; ++i) {
    const VecQ q = random_matrix(random, 6, 1);
    const VecX x = random_matrix(random, 6, 1);
    const VecA standard = force(RendererKind::kStandard, *map, q, x, Z_q);
    const VecA null_space = force(RendererKind::kNullSpace, *map, q, x, Z_q);
    ASSERT_LT((standard - null_space).norm(), 1e-12 * standard.norm());
    // tau_null = k J_aa^T J_aa dq_a
    const Eigen::Matrix3d J_aa = A.topLeftCorner(3, 3);
    const Eigen::Vector3d dq_a = J_aa.inverse() * (x - A * q).head(3);
    const Eigen::VectorXd expected = 700.0 / J_aa.squaredNorm() * J_aa.transpose() * J_aa * dq_a;
    ASSERT_LT((null_space - expected).norm(), 1e-12 * expected.norm());
  }
}

/// tests/report/STUDY.md#null-space-stiffness: tau_null = K_null dq_a with K_null = k J_a^T N J_a,
/// dq_a the deviation of Eq. (8).
TEST(Renderers, NullSpaceIsReweightedSubspaceMethod) {
  std::mt19937_64 random(6);
  for (int i = 0; i < 500; ++i) {
    const Eigen::MatrixXd A = random_matrix(random, 6, 4);
    const auto map = linear_map(A, 2);
    const VecA Z_q = VecA::Constant(2, 900.0);
    const VecQ q = random_matrix(random, 4, 1);
    const VecX x = random_matrix(random, 6, 1);
    const Eigen::MatrixXd J_a = A.leftCols(2), J_n = A.rightCols(2);
    const double z_x = 900.0 / J_a.squaredNorm();
    const Eigen::VectorXd dq_a = force(RendererKind::kSubspaceLinear, *map, q, x, Z_q) / 900.0;
    const Eigen::VectorXd off = oracle::off_columns(J_n) * (J_a * dq_a);
    const Eigen::VectorXd expected = z_x * (J_a.transpose() * off);
    ASSERT_LT((force(RendererKind::kNullSpace, *map, q, x, Z_q) - expected).norm(),
              1e-13 * 10 * expected.norm());
  }
}

TEST(Renderers, ReportARankDeficientJacobian) {
  const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(2, 2);
  Eigen::MatrixXd parallel(2, 2);
  parallel << 1.0, 2.0, 0.5, 1.0;
  Eigen::MatrixXd nearly = parallel;
  nearly(1, 1) += 1e-12;
  Eigen::MatrixXd wide(2, 4);
  wide << .125730, -.132105, .640423, .104900, -.535669, .361595, 1.304000, .947081;
  for (const Eigen::MatrixXd& A : {zero, parallel, nearly, wide}) {
    const int n_q = static_cast<int>(A.cols());
    const auto map = linear_map(A, 1, 10.0);
    const VecQ q = VecQ::Constant(n_q, 0.1);
    const VecX x = VecX::Constant(2, 0.7);
    for (const RendererKind kind : kEveryRenderer) {
      Projection out;
      const VecA tau = force(kind, *map, q, x, VecA::Constant(1, 1000.0), &out);
      ASSERT_TRUE(tau.allFinite()) << name(kind) << "\n" << A;
      ASSERT_LT(tau.norm(), 1e5) << name(kind) << "\n" << A;
      if (kind != RendererKind::kStandard) {
        EXPECT_TRUE(out.status == ProjectionStatus::kRankDeficient ||
                    out.status == ProjectionStatus::kIllConditioned)
            << name(kind) << "\n"
            << A;
      }
    }
  }
}

TEST(Renderers, WideAnswerHasMinimumNorm) {
  Eigen::MatrixXd A(2, 3);
  A << 1.0, 0.4, -0.2, 0.1, 0.8, 0.5;
  const auto map = linear_map(A, 3);
  const VecA Z_q = (VecA(3) << 1.0, 50.0, 400.0).finished();
  const VecX x = (VecX(2) << 0.3, -0.2).finished();
  const VecA tau = force(RendererKind::kSubspaceLinear, *map, VecQ::Zero(3), x, Z_q);
  const Eigen::VectorXd dq = oracle::least_squares_in_metric(A, x, Z_q, 1e-8);
  EXPECT_LT((tau - Z_q.cwiseProduct(dq)).norm(), 1e-12 * tau.norm());
}

/// Case by tests/report/STUDY.md#fig-4-finger_sign_change: the error of Eq. (8) against (6) falls
/// with the square of the deviation.
TEST(Renderers, SmallDeviationMakesExactLinearised) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  const VecA Z_q = VecA::Constant(1, 1500.0);
  VecQ q;
  ASSERT_EQ(finger->inverse((VecX(2) << 0.6, 0.7).finished(), q), InverseStatus::kExact);
  double previous = 0.0;
  for (double size = 0.01; size > 0.0003; size /= 2.0) {
    const VecX x = (VecX(2) << 0.6 - size, 0.7 - 0.5 * size).finished();
    const double linear = force(RendererKind::kSubspaceLinear, *finger, q, x, Z_q)[0];
    const double exact = force(RendererKind::kSubspaceExact, *finger, q, x, Z_q)[0];
    const double error = std::abs(linear - exact);
    if (previous > 0.0) {
      EXPECT_NEAR(previous / error, 4.0, 0.6) << "size " << size;
    }
    previous = error;
  }
}

TEST(DirectionGuard, WithholdsOnlyForceAwayFromProxy) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  DirectionGuard guard(*finger);
  const VecA Z_q = VecA::Constant(1, 1500.0);
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> mcp(0.0, 1.3), pip(0.0, 1.5);
  int withheld = 0, allowed = 0;
  for (int i = 0; i < 4000; ++i) {
    VecQ q;
    VecX x_probe, dx;
    MatXQ J;
    if (finger->inverse((VecX(2) << mcp(random), pip(random)).finished(), q) !=
        InverseStatus::kExact) {
      continue;
    }
    const VecX x = (VecX(2) << mcp(random), pip(random)).finished();
    ASSERT_EQ(finger->evaluate(q, x_probe, J), MapStatus::kOk);
    finger->space().difference(x, x_probe, dx);
    // tau_x . dx with tau_x = w tau_a, w = (S J^{-1})^T: the work the finger would feel.
    const Eigen::Matrix2d J2 = J;
    const double along = J2.inverse().row(0).dot(Eigen::Vector2d(dx));
    for (const RendererKind kind : kEveryRenderer) {
      const VecA tau = force(kind, *finger, q, x, Z_q);
      if (std::abs(tau[0] * along) < 1e-9) continue;
      bool expected = tau[0] * along > 0.0;
      if (kind == RendererKind::kSubspaceLinear || kind == RendererKind::kNullSpace) {
        ASSERT_TRUE(expected)
            << name(kind) << " is never away from the proxy (core/METHOD.md#forces-at-the-finger)";
      }
      // Nor into a joint's contact, if both joints are displaced the same way.
      for (int k = 0; k < 2 && dx[0] * dx[1] > 0.0; ++k) {
        const Eigen::RowVector2d w = J2.inverse().row(0);
        if (std::abs(dx[k]) <= contact_band(*finger)) continue;
        if (std::abs(w[k]) < 0.05 * w.norm()) continue;  // hardly any leverage
        expected = expected && tau[0] * w[k] * dx[k] >= 0.0;
      }
      ASSERT_EQ(guard.allows(Probe{q, x_probe, J}, dx, tau), expected) << name(kind);
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
    VecQ q;
    VecX x_probe;
    MatXQ J;
    ASSERT_EQ(finger->inverse((VecX(2) << 0.5 + 0.001 * i, 0.7).finished(), q),
              InverseStatus::kExact);
    ASSERT_EQ(finger->evaluate(q, x_probe, J), MapStatus::kOk);
    const Eigen::Vector2d w = Eigen::Matrix2d(J).inverse().row(0).transpose();
    Contacts contacts;
    contacts.into.resize(2, 2);
    contacts.into.col(0) = -w.normalized();
    contacts.into.col(1) = Eigen::Vector2d(-w[1], w[0]).normalized() + 1e-3 * normal(random) * w;
    contacts.depth = PlaneSet::Offsets::Constant(2, 0.1);
    const VecX dx = 0.01 * w.normalized();
    const Probe probe{q, x_probe, J, {&contacts}};
    ASSERT_TRUE(guard.allows(probe, dx, VecA::Constant(1, 1.0))) << i;
    ASSERT_FALSE(guard.allows(probe, dx, VecA::Constant(1, -1.0))) << i;
  }
}

}  // namespace
}  // namespace haptic::core
