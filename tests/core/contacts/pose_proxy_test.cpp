/// Eq. (6) where x holds orientations: core/METHOD.md#metric-and-limits.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "haptic/core/model/serial_chain.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/support/angles.hpp"

namespace haptic::core {
namespace {

/// A tracked palm with one joint; x is the palm's frame and a frame beyond the joint.
const Kinematics& palm() {
  static const auto map = [] {
    SerialChainParameters chain;
    chain.palm = TrackedPalm{};
    chain.joints.push_back({"a", JointKind::kRevolute, true, "", {{0.1, 0, 0}, {}}});
    chain.outputs = {{"palm", "base", OutputKind::kFrame, {}},
                     {"tip", "", OutputKind::kFrame, {{0.05, 0.02, 0}, {}}}};
    return make_serial_chain(chain);
  }();
  return *map;
}

/// A metre counts as much as a radian: what the tests expect are poses, which every metric finds.
ProjectionModel model() {
  ProjectionSettings settings;
  settings.metric = TaskMetric::from_scales(VecX::Ones(palm().space().n_x()));
  return ProjectionModel(palm(), settings);
}

VecQ at(const Eigen::Vector3d& phi, double joint) {
  return (VecQ(7) << 0.1, -0.2, 0.3, phi, joint).finished();
}

VecX image(const VecQ& q) {
  VecX x;
  EXPECT_EQ(palm().position(q, x), MapStatus::kOk);
  return x;
}

Projection project_pose(Renderer& renderer, const VecQ& q, const VecX& x) {
  return projected(renderer, Instant(palm(), q, x), VecA::Constant(1, 2.0));
}

/// Same pose, whichever rotation vector says so.
double apart(const VecQ& a, const VecQ& b) {
  return Instant(palm(), a, image(b)).dx.norm();
}

/// From a cold start, by a turn of up to 2.5 rad about any axis, whatever the quaternion's sign and
/// length.
TEST(PoseProxy, IsReachedFromFarAway) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> within(-1.0, 1.0);
  Renderer renderer(RendererKind::kSubspaceExact, model());
  for (int trial = 0; trial < 500; ++trial) {
    const Eigen::Vector3d from(within(random), within(random), within(random));
    const Eigen::Vector3d axis =
        Eigen::Vector3d(within(random), within(random), within(random)).normalized();
    const double turn = 2.5 * std::abs(within(random));
    const Eigen::Quaterniond Q =
        Eigen::AngleAxisd(turn, axis) * Eigen::AngleAxisd(from.norm(), from.normalized());
    const Eigen::Vector3d to = rotation_vector({Q.x(), Q.y(), Q.z(), Q.w()});
    const VecQ goal = at(to, 0.5 * within(random));
    VecX x = image(goal);
    if (trial % 2 == 0) x.segment<4>(3) *= -1.3;
    renderer.reset();
    const Projection out = project_pose(renderer, at(from, 0.0), x);
    EXPECT_EQ(out.status, ProjectionStatus::kConverged) << turn;
    EXPECT_LT(apart(out.q_star, goal), 1e-8) << turn;
    EXPECT_NEAR(out.q_star[6], goal[6], 1e-8);
  }
}

/// A tracker's reading jumps from pi to -pi about its axis; the force must not. Eq. (8) starts from
/// the reading itself.
TEST(PoseProxy, JumpAtPiLeavesForceSmooth) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, -2) / 3.0;
  Renderer renderer(RendererKind::kSubspaceLinear, model());
  const VecX x = image(at(3.2 * axis, 0.35));
  double last = 0.0;
  for (int i = 0; i <= 200; ++i) {
    const double turn = kPi - 0.01 + 1e-4 * i;
    VecQ q = at(turn * axis, 0.3);
    palm().nearest_representative(VecQ::Zero(7), q);  // as a device reports it
    const Projection out = project_pose(renderer, q, x);
    const double force = out.q_star[6] - q[6];
    if (i == 0) last = force;
    EXPECT_LT(std::abs(force - last), 1e-4) << turn;
    last = force;
  }
}

/// A palm that turns on and on, as its device reports it (never beyond pi): q* goes along.
TEST(PoseProxy, FollowsAPalmBeyondPi) {
  const Eigen::Vector3d axis = Eigen::Vector3d(2, -1, 2) / 3.0;
  Renderer renderer(RendererKind::kSubspaceExact, model());
  for (int i = 0; i <= 800; ++i) {
    const double turn = 0.02 * i;  // five times pi in all
    VecQ q = at(turn * axis, 0.3);
    palm().nearest_representative(VecQ::Zero(7), q);
    VecQ goal = at((turn + 0.05) * axis, 0.35);
    palm().nearest_representative(VecQ::Zero(7), goal);
    const Projection out = project_pose(renderer, q, image(goal));
    ASSERT_EQ(out.status, ProjectionStatus::kConverged) << turn;
    ASSERT_LT(apart(out.q_star, goal), 1e-8) << turn;
  }
}

}  // namespace
}  // namespace haptic::core
