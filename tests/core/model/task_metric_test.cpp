// W_x of core/METHOD.md#metric-and-limits: what the scene says counts as near in X.
#include "haptic/core/model/task_metric.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <random>

#include "haptic/core/error.hpp"
#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/core/passivity/direction_guard.hpp"
#include "tests/core/linear/random_matrix.hpp"
#include "tests/core/model/sample_maps.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::core {
namespace {

using samples::gaussian;

/// `metres`: how many of the first coordinates are in m; the others are in rad.
std::unique_ptr<Kinematics> weighted_map(const Eigen::MatrixXd& A, int n_a, int metres) {
  LinearMap map = samples::linear_parameters(A, n_a, 1e6, Unit::kRadian);
  for (int i = 0; i < metres; ++i) map.coordinates[static_cast<std::size_t>(i)].unit = Unit::kMetre;
  return make_linear(map);
}

/// Force on a device at q = 0.
VecA weighted_force(RendererKind kind, const ProjectionModel& model, const VecX& x,
                    const VecA& Z_q) {
  const VecQ q = VecQ::Zero(model.layout().n_q());
  return first_force(kind, model, Instant(model.kinematics(), q, x), Z_q);
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
  LinearMap map =
      samples::linear_parameters(Eigen::MatrixXd::Identity(5, 5), 1, 1.0, Unit::kRadian);
  for (std::size_t i = 1; i < 5; ++i) map.coordinates[i].kind = CoordinateKind::kQuaternion;
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
    const Instant at(*map, VecQ::Zero(n_q), x);
    ASSERT_TRUE(guard.share(at.probe(), x, tau) > 0.0);
    ASSERT_EQ(guard.share(at.probe(), x, -tau) > 0.0, tau.norm() == 0.0);
  }
}

}  // namespace
}  // namespace haptic::core
