/// A finger exoskeleton on MuJoCo's finger, soft ball and box, on the shipped pipeline.

#include <gtest/gtest.h>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/mujoco/mujoco_world.hpp"

namespace haptic::mujoco {
namespace {

using core::VecA;
using core::VecQ;
using core::VecX;

constexpr double kActuator = 1500.0;  // N/m
constexpr double kCoupling = 0.15;    // N m/rad

core::PipelineConfig finger_config(core::RendererKind renderer) {
  core::PipelineConfig c;
  c.kinematics = core::make_finger_exoskeleton({});
  c.device.q_lower = (VecQ(2) << -0.002, -1.0).finished();
  c.device.q_upper = (VecQ(2) << 0.035, 1.2).finished();
  c.device.max_effort = VecA::Constant(1, 40.0);
  c.scene.renderer = renderer;
  c.scene.stiffness = VecA::Constant(1, kActuator);
  c.scene.damping = VecA::Zero(1);
  c.scene.force_limit = VecA::Constant(1, 25.0);
  c.scene.slew_limit = VecA::Constant(1, 1e6);
  c.scene.engage_window = VecA::Constant(1, 40.0);
  return c;
}

/// On a way from the open hand to `closed`, rad: MCP, PIP.
struct Worn {
  Worn(double rate_hz, double delay_s, core::RendererKind renderer)
      : config(finger_config(renderer)),
        world(
            World::of_file(std::string(HAPTIC_SOURCE_DIR) + "/client/mujoco/examples/finger.xml")),
        tool(world.m(), world.d(), {joint("q_o1_mcp", 0), joint("q_o2_pip", 1)},
             {.coupling = kCoupling}),
        loop(config, told_by(tool, rate_hz, delay_s, 2), 2.0) {}

  void at(double part) {
    const VecX x = part * (VecX(2) << 1.0, 1.1).finished();
    ASSERT_EQ(config.kinematics->inverse(x, q), core::InverseStatus::kExact);
    loop.tick(q);
    most = std::max(most, std::abs(loop.tau()));
  }
  /// Returns the largest force on the way.
  double go(double a, double b, double seconds) {
    const int ticks = static_cast<int>(1000.0 * seconds);
    most = 0.0;
    for (int k = 1; k <= ticks; ++k) at(a + (b - a) * k / ticks);
    return most;
  }
  void engage(double part) {
    go(part, part, 0.6);
    loop.engage();
    go(part, part, 0.3);
    loop.require_engaged();
  }
  /// MuJoCo's normal forces on the finger, at the actuator: of the displacement f / c by
  /// Eq. (8), Z_q S J^-1 dx. Jacobians of the points of contact by MuJoCo.
  double engine_force() {
    VecX torque = VecX::Zero(2);
    for (int i = 0; i < world.d()->ncon; ++i) {
      const mjContact& c = world.d()->contact[i];
      if (c.efc_address < 0) continue;
      mjtNum force[6], jacobian[3 * 16];
      mj_contactForce(world.m(), world.d(), i, force);
      const int bodies[2] = {world.m()->geom_bodyid[c.geom1], world.m()->geom_bodyid[c.geom2]};
      for (int side = 0; side < 2; ++side) {
        mj_jac(world.m(), world.d(), jacobian, nullptr, c.pos, bodies[side]);
        for (int j = 0; j < 2; ++j) {
          for (int k = 0; k < 3; ++k) {
            torque[j] +=
                (side == 0 ? -1.0 : 1.0) * force[0] * c.frame[k] * jacobian[k * world.m()->nv + j];
          }
        }
      }
    }
    const core::MatXQ& J = loop.J();
    const double way = (J(1, 1) * torque[0] - J(0, 1) * torque[1]) / kCoupling;
    return kActuator * way / (J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0));
  }

  core::PipelineConfig config;
  World world;
  Tool tool;
  test::PipelineLoop loop;
  VecQ q = VecQ::Zero(2);
  double most{0.0};
};

/// HAPTIC_HOLD_S=60 holds for as long as that.
TEST(MujocoFinger, HeldForceIsMujocos) {
  const double seconds = hold_seconds(1.5);
  for (const double rate : {60.0, 120.0, 500.0}) {
    for (const double delay : {0.0, 0.040, 0.100}) {
      for (const double closed : {0.70, 0.95}) {
        SCOPED_TRACE(std::to_string(rate) + "/s, " + std::to_string(delay) + " s, " +
                     std::to_string(closed));
        Worn worn(rate, delay, core::RendererKind::kSubspaceLinear);
        worn.engage(0.0);
        EXPECT_EQ(worn.go(0.0, 0.40, 0.5), 0.0) << "nothing is touched";
        EXPECT_GT(worn.go(0.40, closed, 1.0), 0.05);
        worn.go(closed, closed, 1.4);
        double off = 0.0, most = 0.0;  // the box creeps away from a light press, in half a minute
        for (int i = 0; i < static_cast<int>(1000.0 * (seconds - 1.4)); ++i) {
          worn.at(closed);
          const double engine = worn.engine_force();
          off = std::max(off, std::abs(worn.loop.tau() - engine));
          most = std::max(most, std::abs(engine));
        }
        std::printf("%3.0f/s, %3.0f ms, closed %.2f: %.2f N, off by %.2f %%\n", rate, 1e3 * delay,
                    closed, most, 100.0 * off / most);
        EXPECT_LE(off, 0.01 * most);
        worn.go(closed, 0.40, 0.7);
        EXPECT_EQ(worn.go(0.40, 0.0, 0.3), 0.0);
      }
    }
  }
}

/// The client starts while the finger closes and opens, at any phase.
TEST(MujocoFinger, LateJoinsHaveNoStrayForce) {
  double first = 0.0;  // of the one that began with an open hand
  for (int start = 0; start < 10; ++start) {
    SCOPED_TRACE(start);
    Worn worn(60.0, 0.040, core::RendererKind::kSubspaceLinear);
    double outside = 0.0, inside = 0.0;
    for (int k = 0; k < 5000; ++k) {
      const double part = 0.475 * (1.0 - std::cos(2.0 * M_PI * (0.0005 * k + start / 10.0)));
      if (k % 50 == 0 && k >= 200 && inside == 0.0) worn.loop.engage();
      worn.at(part);
      double& most = part < 0.4 ? outside : inside;
      most = std::max(most, std::abs(worn.loop.tau()));
    }
    EXPECT_EQ(outside, 0.0);
    if (start == 0) first = inside;
    EXPECT_GT(inside, 0.5);
    EXPECT_LT(inside, 1.05 * first);
  }
}

}  // namespace
}  // namespace haptic::mujoco
