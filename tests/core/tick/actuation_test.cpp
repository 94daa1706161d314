#include "core/src/tick/actuation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/core/model/sample_maps.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

using std::chrono::milliseconds;

/// x = q, two actuated slides of 1000 and 500 N/m, force on.
class ActuationTest : public testing::Test {
 protected:
  ActuationTest() {
    config.kinematics = samples::linear_map(MatXQ::Identity(2, 2), 2, 1.0);
    config.scene.stiffness = two(1000.0, 500.0);
    config.scene.damping = two(2.0, 1.0);
    config.scene.force_limit = two(20.0, 10.0);
    config.scene.slew_limit = two(1e9, 1e9);
    life.state = LifecycleState::kEngaged;
    life.arm = true;
    life.gain = life.damping_gain = 1.0;
    sensed.ready = sensed.fresh = sensed.recent = true;
    sensed.q = two(0.0, 0.0);
    sensed.q_a_dot = two(0.0, 0.0);
    anchor.mapped = anchor.anchored = anchor.in_the_way = true;
    anchor.q_star = two(0.004, -0.002);
  }
  /// One tick of a new actuation, with what the rendering would have said.
  Effort first_step() {
    Actuation actuation(ProjectionModel(*config.kinematics, config.projection), config);
    return step(actuation);
  }
  Effort step(Actuation& actuation) {
    const ProjectionModel model(*config.kinematics, config.projection);
    const BlockRenderer renderer(config.scene.renderer, model);
    const MatXQ J = MatXQ::Identity(2, 2);
    const VecX x_probe = sensed.q;
    Settings settings{config.scene, {}};
    if (model.coupling()) settings.Z_q = model.coupling()->matrix(config.scene.stiffness);
    return actuation.step(beat, sensed, anchor, life, settings,
                          {{sensed.q, x_probe, J}, dx, renderer});
  }

  PipelineConfig config{};
  Beat beat{.tick = 1, .dt = milliseconds(1)};
  Sensed sensed{};
  Anchor anchor{};
  Lifecycle life{};
  VecX dx = two(0.004, -0.002);
};

TEST_F(ActuationTest, ForceIsGainZqStretch) {
  life.gain = 0.5;
  const Effort effort = first_step();
  EXPECT_EQ(effort.tau_a, two(2.0, -0.5));
  EXPECT_EQ(effort.tau_elastic, effort.tau_a);
  EXPECT_EQ(effort.q_star, anchor.q_star);
  EXPECT_FALSE(effort.limiters.any() || effort.faults.any());
}

TEST_F(ActuationTest, AddsDampingByItsOwnGain) {
  sensed.q_a_dot = two(0.1, -0.2);
  life.damping_gain = 0.5;
  const Effort effort = first_step();
  EXPECT_NEAR((effort.tau_damping - two(-0.1, 0.1)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((effort.tau_a - two(3.9, -0.9)).norm(), 0.0, 1e-12);
}

TEST_F(ActuationTest, NoAnchorMeansNoElasticForce) {
  anchor.anchored = false;
  EXPECT_EQ(first_step().tau_elastic, two(0.0, 0.0));
}

TEST_F(ActuationTest, DisarmedOrIdleCommandsZero) {
  sensed.q_a_dot = two(0.1, 0.1);
  life.arm = false;
  EXPECT_EQ(first_step().tau_a, two(0.0, 0.0));
  life.arm = true;
  life.state = LifecycleState::kIdle;
  EXPECT_EQ(first_step().tau_a, two(0.0, 0.0));
}

TEST_F(ActuationTest, EachActuatorIsSaturatedByItself) {
  anchor.q_star = two(0.004, -0.5);
  const Effort effort = first_step();
  EXPECT_EQ(effort.tau_a, two(4.0, -10.0));
  EXPECT_TRUE(effort.limiters.has(Limiter::kSaturation));
  EXPECT_FALSE(effort.actuator_limiters[0].any());
  EXPECT_TRUE(effort.actuator_limiters[1].has(Limiter::kSaturation));
}

TEST_F(ActuationTest, GuardWithholdsForceAwayFromProxy) {
  config.scene.direction_guard = true;
  dx = two(-0.004, 0.002);
  const Effort effort = first_step();
  EXPECT_EQ(effort.tau_elastic, two(0.0, 0.0));
  EXPECT_EQ(effort.q_star, sensed.q);
  EXPECT_TRUE(effort.limiters.has(Limiter::kDirectionGuard));
  anchor.mapped = false;
  EXPECT_EQ(first_step().q_star, anchor.q_star) << "there is no J to judge by";
}

TEST_F(ActuationTest, EmptyTankHoldsTheAnchorBack) {
  config.passivity.tank.enabled = true;
  life.engaged = true;
  const Effort effort = first_step();
  EXPECT_TRUE(effort.passivity.throttled);
  EXPECT_TRUE(effort.limiters.has(Limiter::kEnergyTank));
  EXPECT_EQ(effort.q_star, sensed.q) << "nothing to pay it with";
  EXPECT_EQ(effort.tau_elastic, two(0.0, 0.0));
  config.passivity.tank.initial = 0.05;
  EXPECT_EQ(first_step().q_star, anchor.q_star);
}

TEST_F(ActuationTest, NonFiniteCommandBecomesZero) {
  anchor.q_star[1] = std::numeric_limits<double>::quiet_NaN();
  const Effort effort = first_step();
  EXPECT_TRUE(effort.faults.has(Fault::kOutputNotFinite));
  EXPECT_EQ(effort.tau_a, two(0.0, 0.0));
  EXPECT_EQ(effort.tau_elastic, two(0.0, 0.0));
  EXPECT_EQ(effort.tau_damping, two(0.0, 0.0));
}

TEST_F(ActuationTest, ForceLoopRestsWithoutWantedForce) {
  config.force_control.loops.resize(2, {.integral = 10.0, .output_limit = 20.0});
  sensed.tau_measured = two(1.0, 0.0);
  life.gain = life.damping_gain = 0.0;
  Actuation actuation(ProjectionModel(*config.kinematics), config);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(step(actuation).drive, two(0.0, 0.0));
  life.gain = 1.0;
  const Effort effort = step(actuation);
  EXPECT_NEAR(effort.drive[0], 4.0 + 10.0 * 1e-3 * (4.0 - 1.0), 1e-9) << "nothing wound up";
  life.faults.set(Fault::kOutputNotFinite);
  EXPECT_EQ(step(actuation).drive, two(0.0, 0.0));
}

}  // namespace
}  // namespace haptic::core
