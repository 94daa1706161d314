/// The scenes of the general kinematics, each through the real Pipeline, on simulated masses.

#include <Eigen/LU>

#include "hw/simulated/linear.hpp"
#include "tests/server/owner/scene/scene_run.hpp"
#include "tests/server/owner/scene/scene_text.hpp"

namespace haptic::test {
namespace {

using core::VecA;
using core::VecQ;

struct Expected {
  const char* file;
  int n_q, n_a, n_x;
  bool full_rank;  ///< Eq. (6) then has one answer; else there is a prior
};

/// The scene's own masses; of a hand, masses like it that rest where it does, so that statics say
/// where they end.
hw::SimulatedLinearConfig masses_of(const server::DeviceScene& device) {
  if (const auto* own = dynamic_cast<const hw::SimulatedLinearConfig*>(device.source.get())) {
    return *own;
  }
  hw::SimulatedLinearConfig masses;
  masses.target = rest_of(device);
  const Eigen::Index n_q = masses.target.size();
  masses.mass = VecQ::Constant(n_q, 1e-3);
  masses.damping = VecQ::Constant(n_q, 0.02);
  masses.hand_stiffness = VecQ::Constant(n_q, 1.0);
  const core::DofLayout& layout = device.pipeline.kinematics->layout();
  for (int i = 0; i < layout.n_a(); ++i) {
    masses.mass[layout.actuated(i)] = 0.05;
    masses.damping[layout.actuated(i)] = 7.0;
    masses.hand_stiffness[layout.actuated(i)] = 600.0;
  }
  masses.max_effort = device.source->effort();
  return masses;
}

class KinematicsScenes : public testing::TestWithParam<Expected> {
 protected:
  server::Scene scene = shipped_scene(GetParam().file);
  const server::DeviceScene& device = scene.devices.front();
  const core::DofLayout& layout = device.pipeline.kinematics->layout();
  const hw::SimulatedLinearConfig masses = masses_of(device);

  /// A pose whose actuated DoFs are as far from the target as a fifth of the force limit bends Z_q,
  /// alternately to both sides, and whose sensed DoFs are a hundredth of their box away.
  [[nodiscard]] VecQ beside_the_target() const {
    VecQ q = masses.target;
    double side = 1.0;
    for (int i = 0; i < layout.n_a(); ++i, side = -side) {
      q[layout.actuated(i)] +=
          side * 0.2 * device.pipeline.scene.force_limit[i] / device.pipeline.scene.stiffness[i];
    }
    for (int i = 0; i < layout.n_n(); ++i, side = -side) {
      const core::DofSpec& dof =
          device.pipeline.kinematics->dofs()[static_cast<std::size_t>(layout.sensed(i))];
      q[layout.sensed(i)] += side * 0.01 * (dof.upper - dof.lower);
    }
    return q;
  }

  [[nodiscard]] Eigen::MatrixXd Z_q() const {
    const VecA& K = device.pipeline.scene.stiffness;
    const auto& coupling = device.pipeline.projection.coupling;
    return coupling ? Eigen::MatrixXd(coupling->matrix(K))
                    : Eigen::MatrixXd(Eigen::VectorXd(K).asDiagonal());
  }

  void expect_a_sound_tick(const core::TickRecord& record) const {
    EXPECT_FALSE(record.faults().any());
    EXPECT_NE(record.anchor.projection, core::ProjectionStatus::kNone);
    EXPECT_NE(record.anchor.projection, core::ProjectionStatus::kMapFailed);
    EXPECT_TRUE(record.effort.q_star.allFinite());
    EXPECT_TRUE(record.effort.tau_a.allFinite());
    EXPECT_TRUE(
        (record.effort.tau_a.cwiseAbs().array() <= device.pipeline.scene.force_limit.array())
            .all());
  }
};

TEST_P(KinematicsScenes, DescribeTheDevice) {
  EXPECT_EQ(layout.n_q(), GetParam().n_q);
  EXPECT_EQ(layout.n_a(), GetParam().n_a);
  EXPECT_EQ(device.pipeline.kinematics->space().n_x(), GetParam().n_x);
  EXPECT_EQ(device.pipeline.projection.prior.has_value(), !GetParam().full_rank);
  EXPECT_EQ(device.pipeline.projection.metric.is_identity(),
            !device.pipeline.kinematics->space().mixes_units());
}

/// Full rank: at rest K (q*_a - q_a) = K_h (q_a - target), with q*_a the proxy's own pose, whatever
/// the sensed DoFs do. Otherwise: at rest, and nearer to the proxy.
TEST_P(KinematicsScenes, AHeldProxyBalancesTheForces) {
  SceneRun run(device, masses);
  run.engage();
  const VecQ goal = beside_the_target();
  run.hold(goal);
  for (int i = 0; i < 3000; ++i) expect_a_sound_tick(run.tick());
  const core::TickRecord& record = run.record();
  const VecA q_a = layout.select(record.sensed.q), target_a = layout.select(masses.target);
  const VecA K_h = layout.select(masses.hand_stiffness);
  const VecA balance = record.effort.tau_elastic - K_h.cwiseProduct(q_a - target_a);
  EXPECT_LT((balance.array() / device.pipeline.scene.force_limit.array()).abs().maxCoeff(), 1e-6);
  EXPECT_GT((record.effort.tau_elastic.array() / device.pipeline.scene.force_limit.array())
                .abs()
                .maxCoeff(),
            0.01);
  if (GetParam().full_rank) {
    const Eigen::MatrixXd hand = Eigen::VectorXd(K_h).asDiagonal();
    const Eigen::VectorXd pull = Z_q() * layout.select(goal) + hand * target_a;
    const VecA rest = Eigen::PartialPivLU<Eigen::MatrixXd>(Z_q() + hand).solve(pull);
    EXPECT_LT((q_a - rest).cwiseAbs().maxCoeff(), 1e-7);
    EXPECT_LT((record.effort.q_star - goal).cwiseAbs().maxCoeff(), 1e-7);
    EXPECT_LT(record.anchor.residual, 1e-9);
  } else {
    core::VecX x_start, dx;
    core::MatXQ J;
    ASSERT_EQ(device.pipeline.kinematics->evaluate(masses.target, x_start, J),
              core::MapStatus::kOk);
    device.pipeline.kinematics->space().difference(record.anchor.x, x_start, dx);
    const double distance_before = dx.norm();
    device.pipeline.kinematics->space().difference(record.anchor.x, record.anchor.x_probe, dx);
    EXPECT_LT(dx.norm(), 0.8 * distance_before);
  }
}

INSTANTIATE_TEST_SUITE_P(Shipped, KinematicsScenes,
                         testing::Values(Expected{"hand_five_fingers", 10, 5, 10, true},
                                         Expected{"hand_tracked_palm", 16, 5, 39, true},
                                         Expected{"stylus_three_of_six", 6, 3, 7, true},
                                         Expected{"stylus_cartesian", 6, 3, 7, true},
                                         Expected{"chain_pick_arm", 4, 2, 6, true},
                                         Expected{"chain_redundant", 5, 3, 3, false}),
                         [](const auto& test) { return std::string(test.param.file); });

}  // namespace
}  // namespace haptic::test
