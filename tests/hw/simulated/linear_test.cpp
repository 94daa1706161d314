#include "hw/simulated/linear.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "haptic/core/error.hpp"
#include "haptic/core/model/linear.hpp"
#include "tests/hw/virtual_loop.hpp"

namespace haptic::hw {
namespace {

using namespace std::chrono_literals;
using test::VirtualLoop;

/// Two DoFs, the second one actuated; x = q.
std::shared_ptr<const core::Kinematics> plane() {
  core::LinearMap map{.dofs = {{"y", core::Unit::kMetre, false, -0.1, 0.1},
                               {"z", core::Unit::kMetre, true, -0.1, 0.1}},
                      .coordinates = {{"y"}, {"z"}},
                      .A = core::MatXQ::Identity(2, 2),
                      .x_0 = core::VecX::Zero(2)};
  return core::make_linear(map);
}

core::VecQ pair(double a, double b) {
  core::VecQ v(2);
  v << a, b;
  return v;
}

SimulatedLinearConfig config() {
  SimulatedLinearConfig c;
  c.mass = pair(0.2, 0.5);
  c.max_effort = core::VecA::Constant(1, 10.0);
  return c;
}

TEST(SimulatedLinear, AFreeMassFollowsNewton) {
  SimulatedLinear device(config(), plane());
  VirtualLoop loop(device);
  loop.push(2.0);
  loop.run(2ms);  // armed with the second tick, force from there on
  const double start = device.q_dot()[1];
  loop.run(100ms);
  EXPECT_NEAR(device.q_dot()[1] - start, 2.0 / 0.5 * 0.1, 1e-9);
  EXPECT_EQ(device.q()[0], 0.0) << "nothing drives the DoF without actuator";
}

TEST(SimulatedLinear, RestsIfSpringBalancesForce) {
  SimulatedLinearConfig c = config();
  c.hand_stiffness = pair(100.0, 400.0);
  c.hand_damping = pair(1.0, 5.0);
  c.damping = pair(2.0, 20.0);
  c.target = pair(0.03, -0.02);
  SimulatedLinear device(c, plane());
  VirtualLoop loop(device);
  loop.push(4.0);
  loop.run(4s);
  EXPECT_NEAR(device.q()[1], -0.02 + 4.0 / 400.0, 1e-9);
  EXPECT_NEAR(device.q()[0], 0.03, 1e-12);
}

TEST(SimulatedLinear, ADampedMassSlowsDownExponentially) {
  SimulatedLinearConfig c = config();
  c.damping = pair(0.0, 2.0);
  SimulatedLinear device(c, plane());
  VirtualLoop loop(device);
  loop.push(1.0);
  loop.run(30ms);
  loop.push(0.0);
  loop.tick();
  const double start = device.q_dot()[1];
  loop.run(100ms);
  // The zero-force write of the tick above acts from its read on.
  EXPECT_NEAR(device.q_dot()[1] / start, std::exp(-2.0 / 0.5 * 0.1), 1e-3);
}

TEST(SimulatedLinear, AnyStiffnessIsStable) {
  SimulatedLinearConfig c = config();
  c.hand_stiffness = pair(1e9, 1e9);
  c.mass = pair(1e-6, 1e-6);
  c.target = pair(0.05, 0.05);
  SimulatedLinear device(c, plane());
  VirtualLoop loop(device);
  loop.push(10.0);
  loop.run(1s);
  EXPECT_NEAR(device.q()[1], 0.05, 1e-6);
  EXPECT_LT(std::abs(device.q_dot()[1]), 1e-9);
}

TEST(SimulatedLinear, BoxEndsDoNotBounce) {
  SimulatedLinear device(config(), plane());
  VirtualLoop loop(device);
  loop.push(10.0);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_LE(loop.tick().sample.q[1], 0.1);
    EXPECT_GE(device.q_dot()[1], 0.0);
  }
  EXPECT_EQ(device.q()[1], 0.1);
  EXPECT_EQ(device.q_dot()[1], 0.0);
}

TEST(SimulatedLinear, ForceStaysWithinMaxEffort) {
  SimulatedLinear strong(config(), plane()), limited(config(), plane());
  VirtualLoop a(strong), b(limited);
  a.push(10.0);
  b.push(1e9);
  a.run(50ms);
  b.run(50ms);
  EXPECT_EQ(strong.q()[1], limited.q()[1]);
  b.push(std::numeric_limits<double>::quiet_NaN());
  b.run(20ms);
  EXPECT_TRUE(limited.q().allFinite());
}

}  // namespace
}  // namespace haptic::hw
