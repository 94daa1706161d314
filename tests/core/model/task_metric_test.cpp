// W_x of core/METHOD.md#metric-and-limits: what the scene says counts as near in X.
#include "haptic/core/model/task_metric.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <random>

#include "haptic/core/error.hpp"
#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/core/model/linear.hpp"
#include "haptic/core/passivity/direction_guard.hpp"
#include "haptic/core/rendering/renderer.hpp"
#include "tests/core/linear/random_matrix.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::core {
namespace {

using samples::gaussian;

/// `metres`: how many of the first coordinates are in m; the others are in rad.
std::unique_ptr<Kinematics> weighted_map(const Eigen::MatrixXd& A, int n_a, int metres) {
  LinearMap map;
  for (int i = 0; i < A.cols(); ++i) {
    map.dofs.push_back({"q" + std::to_string(i), Unit::kMetre, i < n_a, -1e6, 1e6});
  }
  for (int i = 0; i < A.rows(); ++i) {
    map.coordinates.push_back({"x" + std::to_string(i), i < metres ? Unit::kMetre : Unit::kRadian});
  }
  map.A = A;
  return make_linear(map);
}

VecA weighted_force(RendererKind kind, const ProjectionModel& model, const VecX& x,
                    const VecA& Z_q) {
  VecX x_probe, dx;
  MatXQ J;
  const VecQ q = VecQ::Zero(model.layout().n_q());
  EXPECT_EQ(model.kinematics().evaluate(q, x_probe, J), MapStatus::kOk);
  model.kinematics().space().difference(x, x_probe, dx);
  Renderer renderer(kind, model);
  Projection out;
  renderer.project(Probe{q, x_probe, J}, x, dx, Z_q, true, out);
  return Z_q.cwiseProduct(model.layout().select(out.q_star));
}

ProjectionSettings with_metric(TaskMetric metric) {
  ProjectionSettings settings;
  settings.metric = std::move(metric);
  return settings;
}

TEST(TaskMetric, HasNoDefaultForMixedUnits) {
  const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(3, 2);
  const auto mixed = weighted_map(A, 1, 2), metres = weighted_map(A, 1, 3);
  EXPECT_NO_THROW(ProjectionModel{*metres});
  EXPECT_THROW(ProjectionModel{*mixed}, SceneError);
  EXPECT_NO_THROW(ProjectionModel(*mixed, with_metric(TaskMetric::from_scales(VecX::Ones(3)))));
  EXPECT_THROW(ProjectionModel(*mixed, with_metric(TaskMetric::from_scales(VecX::Ones(2)))),
               SceneError);
}

TEST(TaskMetric, RefusesAnInvalidMetric) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {0.0, -1.0, kNan, std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW((void)TaskMetric::from_scales((VecX(2) << 1.0, bad).finished()), SceneError);
  }
  EXPECT_THROW((void)TaskMetric::from_scales(VecX()), SceneError);
  const auto refused = [](const Eigen::MatrixXd& W) {
    EXPECT_THROW((void)TaskMetric::from_matrix(W), SceneError) << W;
  };
  refused((Eigen::Matrix2d() << 1, 0.1, 0.2, 1).finished());  // not symmetric
  refused((Eigen::Matrix2d() << 1, 2, 2, 1).finished());      // not positive
  refused((Eigen::Matrix2d() << 1, 0, 0, 0).finished());
  refused((Eigen::Matrix2d() << 1, kNan, kNan, 1).finished());
  refused(Eigen::MatrixXd::Identity(2, 3));
}

TEST(TaskMetric, RefusesNearlySingularInAnyUnits) {
  const auto metric = [](double unit, double rest) {
    Eigen::Matrix2d W;
    W << 1.0, unit, unit, unit * unit * (1.0 + rest);
    return W;
  };
  for (const double unit : {1e-6, 1.0, 1e6}) {
    EXPECT_NO_THROW((void)TaskMetric::from_matrix(metric(unit, 1e-9))) << unit;
    EXPECT_THROW((void)TaskMetric::from_matrix(metric(unit, 1e-13)), SceneError) << unit;
  }
}

/// q and -q are one rotation: what a tie to them weighs would depend on which of them is written.
TEST(TaskMetric, RotationIsTiedToNothingElse) {
  LinearMap map;
  for (int i = 0; i < 5; ++i) {
    map.dofs.push_back({"q" + std::to_string(i), Unit::kMetre, i == 0, -1.0, 1.0});
    const auto kind = i == 0 ? CoordinateKind::kLinear : CoordinateKind::kQuaternion;
    map.coordinates.push_back({"x" + std::to_string(i), Unit::kRadian, kind});
  }
  map.A = Eigen::MatrixXd::Identity(5, 5);
  const auto kinematics = make_linear(map);
  Eigen::MatrixXd W = Eigen::MatrixXd::Identity(5, 5);
  W(2, 1) = W(1, 2) = 0.5;
  EXPECT_NO_THROW(ProjectionModel(*kinematics, with_metric(TaskMetric::from_matrix(W))));
  W(2, 0) = W(0, 2) = 0.1;
  EXPECT_THROW(ProjectionModel(*kinematics, with_metric(TaskMetric::from_matrix(W))), SceneError);
}

TEST(TaskMetric, BlockTakesItsPartOfIt) {
  std::mt19937_64 random(5);
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(6, 6);
  for (int first = 0; first < 6; first += 2) {
    const Eigen::MatrixXd B = gaussian(random, 2, 2);
    W.block(first, first, 2, 2) = oracle::product(B, B.transpose());
  }
  W(0, 4) = W(4, 0) = 1e-3;
  const TaskMetric metric = TaskMetric::from_matrix(W);
  EXPECT_NEAR((metric.matrix() - W).norm(), 0.0, 1e-14 * W.norm());
  EXPECT_FALSE(metric.separates(0, 2));
  EXPECT_TRUE(metric.separates(2, 2));
  EXPECT_FALSE(metric.separates(4, 2));
  EXPECT_NEAR((metric.of(2, 2).matrix() - W.block(2, 2, 2, 2)).norm(), 0.0, 1e-14);
  const VecX a = gaussian(random, 6, 1);
  EXPECT_NEAR((W * metric.steepest(a) - a).norm(), 0.0, 1e-11 * a.norm());
}

TEST(TaskMetric, FingersStaySeparateUnlessTied) {
  const auto hand =
      make_hand_exoskeleton({{"index", finger_sign_change()}, {"ring", finger_sign_change()}});
  Eigen::MatrixXd W = Eigen::MatrixXd::Identity(4, 4);
  W(0, 1) = W(1, 0) = 0.5;
  EXPECT_TRUE(ProjectionModel(*hand, with_metric(TaskMetric::from_matrix(W))).has_blocks());
  W(1, 2) = W(2, 1) = 0.1;
  EXPECT_FALSE(ProjectionModel(*hand, with_metric(TaskMetric::from_matrix(W))).has_blocks());
}

TEST(TaskMetric, ItsRootSquaredIsTheMetric) {
  std::mt19937_64 random(1);
  for (int n = 1; n <= kMaxX; n += 7) {
    const Eigen::MatrixXd B = gaussian(random, n, n);
    Eigen::MatrixXd W = oracle::product(B, B.transpose());
    W.diagonal().array() += 1.0;
    const TaskMetric metric = TaskMetric::from_matrix(W);
    const VecX v = gaussian(random, n, 1);
    VecX weighed = v;
    metric.weigh(weighed);
    EXPECT_NEAR(weighed.squaredNorm(), v.dot(W * v), 1e-12 * v.dot(W * v) * n);
  }
}

/// Eq. (1), (4), (8) with Z_x = z_x W, written out densely.
TEST(TaskMetric, EveryRendererMeasuresByIt) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 400; ++trial) {
    const int n_x = 4 + trial % 3, n_q = 3, n_a = 1 + trial % 2;
    const Eigen::MatrixXd A = gaussian(random, n_x, n_q), B = gaussian(random, n_x, n_x);
    Eigen::MatrixXd W = oracle::product(B, B.transpose());
    W.diagonal().array() += 0.1;
    const auto map = weighted_map(A, n_a, n_x / 2);
    const ProjectionModel model(*map, with_metric(TaskMetric::from_matrix(W)));
    const VecX x = gaussian(random, n_x, 1);
    const VecA Z_q = VecA::Constant(n_a, 300.0);
    const Eigen::MatrixXd J_a = A.leftCols(n_a), J_n = A.rightCols(n_q - n_a);
    const double z_x = 300.0 / J_a.cwiseProduct(oracle::product(W, J_a)).sum();
    const Eigen::VectorXd f = z_x * (W * x);
    // Eq. (3) in the metric W^{-1} on forces: f* = f - W J_n (J_n^T W J_n)^{-1} J_n^T f.
    const Eigen::VectorXd f_star =
        z_x * (W * (x - J_n * oracle::weighted_least_squares(J_n, W, x)));
    const Eigen::VectorXd dq = oracle::weighted_least_squares(A, W, x);
    const Eigen::VectorXd want[] = {J_a.transpose() * f, J_a.transpose() * f_star,
                                    300.0 * dq.head(n_a), 300.0 * dq.head(n_a)};
    for (int k = 0; k < 4; ++k) {
      const VecA got = weighted_force(kEveryRenderer[k], model, x, Z_q);
      ASSERT_LT((got - want[k]).norm(), 1e-8 * (want[k].norm() + 1.0)) << name(kEveryRenderer[k]);
    }
  }
}

/// tests/report/STUDY.md#change-of-units, with mixed units in X and Q: metres or millimetres,
/// radians or degrees, the same force.
TEST(TaskMetric, ForceIgnoresTheUnits) {
  std::mt19937_64 random(3);
  constexpr double kDegrees = 57.295779513082323;
  for (int trial = 0; trial < 1000; ++trial) {
    const Eigen::MatrixXd A = gaussian(random, 4, 3);
    const VecX scale = (VecX(4) << 0.005, 0.005, 0.1, 0.1).finished();
    const VecX in_x = (VecX(4) << 1e3, 1e3, kDegrees, kDegrees).finished();
    const VecQ in_q = (VecQ(3) << 1e3, 1e3, kDegrees).finished();
    const Eigen::MatrixXd A_units = in_x.asDiagonal() * A * in_q.cwiseInverse().asDiagonal();
    const auto si = weighted_map(A, 2, 2), other = weighted_map(A_units, 2, 2);
    const ProjectionModel model(*si, with_metric(TaskMetric::from_scales(scale)));
    const ProjectionModel same(*other,
                               with_metric(TaskMetric::from_scales(scale.cwiseProduct(in_x))));
    const VecX x = scale.cwiseProduct(VecX(gaussian(random, 4, 1)));
    const VecA Z_q = (VecA(2) << 1500.0, 700.0).finished();
    for (const RendererKind kind : {RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact}) {
      const VecA newton = weighted_force(kind, model, x, Z_q);
      // N/mm against N/m; a force in N comes out, in units of (N/mm) mm.
      const VecA again = weighted_force(kind, same, x.cwiseProduct(in_x), Z_q / 1e3);
      const double condition = 100.0;  // of most of these J; the bound is 1e-12 relative to it
      ASSERT_LT((newton - again).norm(), 1e-12 * condition * (1.0 + newton.norm())) << name(kind);
    }
  }
}

TEST(TaskMetric, DecidesWhichErrorRemains) {
  // One actuated DoF moves both coordinates; the proxy asks them apart.
  const auto map = weighted_map((Eigen::MatrixXd(2, 1) << 1.0, 1.0).finished(), 1, 2);
  const VecX x = (VecX(2) << 0.01, -0.02).finished();
  const auto q_star = [&](double s0, double s1) {
    const ProjectionModel model(
        *map, with_metric(TaskMetric::from_scales((VecX(2) << s0, s1).finished())));
    return weighted_force(RendererKind::kSubspaceExact, model, x, VecA::Ones(1))[0];
  };
  EXPECT_NEAR(q_star(1.0, 1.0), -0.005, 1e-15);
  EXPECT_NEAR(q_star(1e-4, 1.0), 0.01, 1e-8);
  EXPECT_NEAR(q_star(1.0, 1e-4), -0.02, 1e-8);
}

TEST(TaskMetric, GuardNeverWithholdsTheLinearisedForce) {
  std::mt19937_64 random(4);
  for (int trial = 0; trial < 500; ++trial) {
    const int n_q = 1 + trial % 4;  // wide where n_q > 3
    const Eigen::MatrixXd A = gaussian(random, 3, n_q);
    const auto map = weighted_map(A, 1 + trial % n_q, 1);
    const ProjectionModel model(
        *map, with_metric(TaskMetric::from_scales((VecX(3) << 0.005, 0.1, 0.2).finished())));
    VecA Z_q = VecA(gaussian(random, model.layout().n_a(), 1)).cwiseAbs() +
               VecA::Constant(model.layout().n_a(), 0.1);
    const VecX x = gaussian(random, 3, 1);
    const VecA tau = weighted_force(RendererKind::kSubspaceLinear, model, x, Z_q);
    DirectionGuard guard(model, Z_q);
    const VecQ q = VecQ::Zero(n_q);
    const VecX x_probe = VecX::Zero(3);
    const MatXQ J = A;
    ASSERT_TRUE(guard.allows(Probe{q, x_probe, J}, x, tau));
    ASSERT_EQ(guard.allows(Probe{q, x_probe, J}, x, -tau), tau.norm() == 0.0);
  }
}

}  // namespace
}  // namespace haptic::core
