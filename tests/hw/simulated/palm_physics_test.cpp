/// The palm on the user's arm, against the closed form of a mass on a spring and a damper.
#include "hw/simulated/palm_physics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace haptic::hw {
namespace {

using Eigen::Vector3d;

constexpr double kStep = 1e-4;

PalmPhysics at_origin(const ArmParameters& arm = {}) {
  return {arm, PalmPose{}, -1.0, 1.0};
}

/// The rest of an aim that jumps by 1 at t = 0: M e_ddot + B e_dot + K e = 0 with e(0) = 1 and,
/// because the damper sees the jump too, e_dot(0) = -B/M. Underdamped.
double left_of_a_jump(double M, double K, double B, double t) {
  const double decay = B / (2.0 * M);
  const double omega = std::sqrt(K / M - decay * decay);
  return std::exp(-decay * t) * (std::cos(omega * t) - decay / omega * std::sin(omega * t));
}

TEST(PalmPhysics, AJumpFollowsTheClosedForm) {
  const ArmParameters arm;
  PalmPhysics palm = at_origin();
  const PalmPose aim{{0.1, -0.2, 0.05}, {0.0, 0.4, 0.0}};
  for (int i = 1; i <= 6000; ++i) {
    palm.step(kStep, aim);
    if (i % 100 != 0) continue;
    const double t = i * kStep;
    const double shift = left_of_a_jump(arm.mass, arm.stiffness, arm.damping, t);
    const double turn =
        left_of_a_jump(arm.inertia, arm.rotation_stiffness, arm.rotation_damping, t);
    const PalmPose pose = palm.ahead(0.0);
    EXPECT_LT((pose.position - (1.0 - shift) * aim.position).norm(), 0.002 * 0.23) << t;
    EXPECT_LT((pose.rotation - (1.0 - turn) * aim.rotation).norm(), 0.004 * 0.4) << t;
  }
  EXPECT_LT((palm.ahead(0.0).position - aim.position).norm(), 1e-4);
}

TEST(PalmPhysics, OnlyAccelerationLagsBehind) {
  // A steady aim is followed without lag, one that accelerates by m a / K.
  const ArmParameters arm;
  PalmPhysics steady = at_origin(), faster = at_origin();
  PalmPose aim;
  for (int i = 1; i <= 8000; ++i) {
    const double t = i * kStep;
    aim.position = Vector3d(0.3 * t, 0.0, 0.0);
    steady.step(kStep, aim);
    aim.position = Vector3d(0.0, 0.5 * 2.0 * t * t, 0.0);
    faster.step(kStep, aim);
  }
  EXPECT_NEAR(steady.ahead(0.0).position[0], 0.3 * 0.8, 1e-5);
  EXPECT_NEAR(aim.position[1] - faster.ahead(0.0).position[1], arm.mass * 2.0 / arm.stiffness,
              5e-5);
}

TEST(PalmPhysics, TurnsThroughPi) {
  // One and a half turns about an axis: the pose is the intended one, its vector the shortest.
  PalmPhysics palm = at_origin();
  const Vector3d axis = Vector3d(1.0, 2.0, -2.0) / 3.0;
  const double end = 3.0 * std::numbers::pi + 0.2;
  for (int i = 1; i <= 40000; ++i) palm.step(kStep, {{}, axis * end * std::min(1.0, i / 30000.0)});
  const Vector3d expected = (end - 4.0 * std::numbers::pi) * axis;
  EXPECT_LT((palm.ahead(0.0).rotation - expected).norm(), 1e-6);
}

TEST(PalmPhysics, TheArmIsPassive) {
  // Once the aim stands, spring and kinetic energy only fall; all that the palm has is the arm's.
  const ArmParameters arm{.mass = 0.5, .damping = 0.0, .rotation_damping = 0.0};
  PalmPhysics palm = at_origin(arm);
  const PalmPose aim{{0.2, 0.1, 0.0}, {0.5, 0.0, 0.3}};
  const double given = 0.5 * arm.stiffness * aim.position.squaredNorm() +
                       0.5 * arm.rotation_stiffness * aim.rotation.squaredNorm();
  double most = given;
  for (int i = 0; i < 20000; ++i) {
    palm.step(kStep, aim);
    const PalmPose pose = palm.ahead(0.0);
    const double stored =
        palm.kinetic() + 0.5 * arm.stiffness * (aim.position - pose.position).squaredNorm() +
        0.5 * arm.rotation_stiffness * (aim.rotation - pose.rotation).squaredNorm();
    ASSERT_LE(stored, most * (1.0 + 1e-9)) << i;
    most = std::min(most, stored);
    ASSERT_LE(palm.kinetic(), palm.by_arm() + 1e-12);
  }
  EXPECT_GT(most, 0.7 * given) << "nothing damps but the integration";
}

TEST(PalmPhysics, TheBoxEndsTheWay) {
  PalmPhysics palm = at_origin();
  for (int i = 0; i < 10000; ++i) palm.step(kStep, {{1.4, 0.2, -3.0}, {}});
  const Vector3d position = palm.ahead(0.01).position;
  EXPECT_EQ(position[0], 1.0);
  EXPECT_EQ(position[2], -1.0);
  EXPECT_NEAR(position[1], 0.2, 1e-4);
  EXPECT_EQ(palm.velocity()[0], 0.0);
}

TEST(PalmPhysics, AnyStiffnessIsStable) {
  PalmPhysics palm = at_origin({.mass = 1e-3, .stiffness = 1e9, .rotation_stiffness = 1e9});
  const PalmPose aim{{0.3, 0.0, 0.0}, {0.0, 0.0, 1.0}};
  for (int i = 0; i < 1000; ++i) palm.step(kStep, aim);
  EXPECT_LT((palm.ahead(0.0).position - aim.position).norm(), 1e-6);
  EXPECT_LT((palm.ahead(0.0).rotation - aim.rotation).norm(), 1e-6);
}

}  // namespace
}  // namespace haptic::hw
