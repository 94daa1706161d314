#include "haptic/core/rendering/coupling_metric.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <random>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/core/model/linear.hpp"
#include "haptic/core/model/stylus.hpp"

namespace haptic::core {
namespace {

std::unique_ptr<Kinematics> linear(const MatXQ& A, std::initializer_list<bool> actuated,
                                   Unit coordinates = Unit::kMetre) {
  LinearMap map;
  for (const bool a : actuated) {
    map.dofs.push_back({"q" + std::to_string(map.dofs.size()), Unit::kMetre, a, -1.0, 1.0});
  }
  for (int i = 0; i < A.rows(); ++i)
    map.coordinates.push_back({"x" + std::to_string(i), coordinates});
  map.A = A;
  return make_linear(map);
}

MatXQ jacobian(const Kinematics& map, const VecQ& q) {
  VecX x;
  MatXQ J;
  EXPECT_EQ(map.evaluate(q, x, J), MapStatus::kOk);
  return J;
}

/// For square J the definition reads J^T W J = diag(Z_q, eps k_x ||J_n||^2): what one DoF's motion
/// costs, and no two together.
TEST(CouplingMetric, WeighsEachDofByItself) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  int judged = 0;
  for (int i = 0; judged < 100; ++i) {
    const VecQ q = workspace_sample(*finger, i);
    VecX x;
    MatXQ J;
    if (finger->evaluate(q, x, J) != MapStatus::kOk) continue;
    ++judged;
    const double Z = 1500.0, eps = 0.05;
    const auto W = coupling_metric(*finger, {}, q, VecA::Constant(1, Z), eps);
    ASSERT_TRUE(W);
    const Eigen::MatrixXd in_q = J.transpose() * *W * J;
    const double sensed = eps * Z / J.col(0).squaredNorm() * J.col(1).squaredNorm();
    EXPECT_NEAR(in_q(0, 0) / Z, 1.0, 1e-8);
    EXPECT_NEAR(in_q(1, 1) / sensed, 1.0, 1e-8);
    EXPECT_NEAR(in_q(0, 1) / std::sqrt(Z * sensed), 0.0, 1e-8);
  }
}

/// What no q reaches counts too, softly: without it the metric would be none.
TEST(CouplingMetric, IsDefiniteForMoreCoordinates) {
  const MatXQ A = (MatXQ(4, 2) << 1, 0, 0, 2, 0, 0, 1, 0).finished();
  const auto map = linear(A, {true, false});
  const double Z = 600.0, eps = 0.1;
  const auto W = coupling_metric(*map, {}, VecQ::Zero(2), VecA::Constant(1, Z), eps);
  ASSERT_TRUE(W);
  EXPECT_EQ(Eigen::LLT<Eigen::MatrixXd>(*W).info(), Eigen::Success);
  const double k_x = Z / 2.0;  // ||A_a||^2 = 2
  const Eigen::Vector4d off(1.0, 0.0, 0.0, -1.0), third(0.0, 0.0, 1.0, 0.0), n(0.0, 1.0, 0.0, 0.0);
  EXPECT_NEAR(off.dot(*W * off), 2.0 * eps * k_x, 1e-10);
  EXPECT_NEAR(third.dot(*W * third), eps * k_x, 1e-10);
  EXPECT_NEAR(n.dot(*W * n), eps * k_x, 1e-10) << "q_n = 1/2, ||A_n||^2 = 4";
  const Eigen::Vector4d a(1.0, 0.0, 0.0, 1.0);
  EXPECT_NEAR(a.dot(*W * a), Z, 1e-10);
}

TEST(CouplingMetric, FullActuationGivesTheStiffnessItself) {
  const MatXQ A = (MatXQ(2, 2) << 1, 2, -1, 3).finished();
  const auto map = linear(A, {true, true});
  const VecA Z = (VecA(2) << 300.0, 20.0).finished();
  const Eigen::Matrix2d inverse = Eigen::Matrix2d(A).inverse();
  const Eigen::Matrix2d want = inverse.transpose() * Z.asDiagonal() * inverse;
  for (const double eps : {1.0, 1e-3}) {
    const auto W = coupling_metric(*map, {}, VecQ::Zero(2), Z, eps);
    ASSERT_TRUE(W);
    EXPECT_LT((*W - want).norm(), 1e-11 * want.norm());
  }
}

/// tests/report/STUDY.md#change-of-units: the unit of no DoF and of no coordinate shows in
/// ||dx||_W.
TEST(CouplingMetric, IsFreeOfUnits) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int i = 0; i < 200; ++i) {
    MatXQ A(4, 3);
    VecX dx(4);
    for (int k = 0; k < 12; ++k) A.data()[k] = any(random);
    for (double& d : dx) d = any(random);
    const VecA Z = (VecA(2) << 400.0, 30.0).finished();
    const auto plain = coupling_metric(*linear(A, {true, false, true}), {}, VecQ::Zero(3), Z, 0.01);
    // q0 in mm, q1 in degrees, q2 in cm; x0, x1 in mm with a metric that says so.
    const Eigen::Vector3d q_unit(1e3, 57.29577951308232, 1e2);
    const Eigen::Vector4d x_unit(1e3, 1e3, 1.0, 1.0);
    const MatXQ B = x_unit.asDiagonal() * A * q_unit.cwiseInverse().asDiagonal();
    const VecA Z_in_units = (VecA(2) << 400.0 / 1e6, 30.0 / 1e4).finished();
    const auto other =
        coupling_metric(*linear(B, {true, false, true}), TaskMetric::from_scales(VecX(x_unit)),
                        VecQ::Zero(3), Z_in_units, 0.01);
    ASSERT_TRUE(plain && other);
    const Eigen::Vector4d dx_other = x_unit.asDiagonal() * dx;
    const double cost = dx.dot(*plain * dx);
    EXPECT_NEAR(dx_other.dot(*other * dx_other) / cost, 1.0, 1e-9);
  }
}

TEST(CouplingMetric, IsAbsentWithoutJacobianOrStiffness) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  const VecQ q = (VecQ(2) << 0.016, -0.26).finished();
  const VecA Z = VecA::Constant(1, 1500.0);
  EXPECT_TRUE(coupling_metric(*finger, {}, q, Z, 0.01));
  EXPECT_FALSE(coupling_metric(*finger, {}, q, VecA::Zero(1), 0.01)) << "no stiffness";
  EXPECT_FALSE(coupling_metric(*finger, {}, (VecQ(2) << 0.0, -0.588).finished(), Z, 0.01))
      << "no f";
  EXPECT_FALSE(coupling_metric(*finger, {}, VecQ::Zero(0), Z, 0.01)) << "no sample yet";
  const MatXQ lost = (MatXQ(2, 2) << 1, 2, 2, 4).finished(), wide = MatXQ::Ones(1, 2);
  EXPECT_FALSE(coupling_metric(*linear(lost, {true, false}), {}, VecQ::Zero(2), Z, 0.01));
  EXPECT_FALSE(coupling_metric(*linear(wide, {true, false}), {}, VecQ::Zero(2), Z, 0.01));
}

TEST(CouplingMetric, ComesInBlocksRowByRow) {
  const auto hand = make_hand_exoskeleton(
      {{"thumb", scaled(finger_sign_change(), 0.8)}, {"index", finger_sign_change()}});
  const auto index = make_finger_exoskeleton(finger_sign_change());
  const VecQ q = (VecQ(4) << 0.012, -0.2, 0.016, -0.26).finished();
  const VecA Z = (VecA(2) << 900.0, 1500.0).finished();
  const auto blocks = coupling_blocks(ProjectionModel(*hand), q, Z, 0.02);
  ASSERT_EQ(blocks.size(), 2u);
  const auto W = coupling_metric(*index, {}, q.tail(2), Z.tail(1), 0.02);
  ASSERT_TRUE(W);
  EXPECT_EQ(blocks[1].coordinates, 2);
  ASSERT_EQ(blocks[1].lower.size(), 3u);
  EXPECT_EQ(blocks[1].lower[0], (*W)(0, 0));
  EXPECT_EQ(blocks[1].lower[1], (*W)(1, 0));
  EXPECT_EQ(blocks[1].lower[2], (*W)(1, 1));
  EXPECT_EQ(blocks[0].lower.size(), 3u);
  const auto none = coupling_blocks(ProjectionModel(*hand), VecQ(), Z, 0.02);
  ASSERT_EQ(none.size(), 2u);
  EXPECT_EQ(none[0].coordinates, 2);
  EXPECT_TRUE(none[0].lower.empty());
}

/// core/METHOD.md#anisotropic-coupling: the softer, the less of the way onto a plane is asked of
/// the actuator, as long as the sensed DoF alone reaches it; the law is dq_a = -d Z_q^{-1} a /
/// (a^2/Z_q + b^2/D_n), a = J_a.n, b = J_n.n.
TEST(CouplingMetric, PullsTheProxyAlongSoftDirections) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  const VecQ q = (VecQ(2) << 0.016, -0.26).finished();
  const double Z = 1500.0, depth = 0.1;
  const Eigen::Matrix2d J = jacobian(*finger, q);
  const Eigen::Vector2d n(0.6, 0.8);
  const double a = J.col(0).dot(n), b = J.col(1).dot(n);
  double last = 1e300;
  for (const double eps : {1.0, 0.1, 0.01, 0.001}) {
    const Eigen::Matrix2d W = coupling_metric(*finger, {}, q, VecA::Constant(1, Z), eps).value();
    const Eigen::Vector2d along = W.inverse() * n;
    const Eigen::Vector2d dx = -depth * along / n.dot(along);
    const Eigen::Vector2d dq = J.inverse() * dx;
    const double D_n = eps * Z * J.col(1).squaredNorm() / J.col(0).squaredNorm();
    EXPECT_NEAR(dq[0], -depth * (a / Z) / (a * a / Z + b * b / D_n), 1e-9);
    EXPECT_LT(std::abs(dq[0]), last);
    last = std::abs(dq[0]);
  }
}

}  // namespace
}  // namespace haptic::core
