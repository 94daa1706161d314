#include "haptic/core/model/configuration_space.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "haptic/core/error.hpp"
#include "tests/core/model/unit_quaternion.hpp"
#include "tests/support/angles.hpp"

namespace haptic::core {
namespace {

Coordinate part(const char* name) {
  return {name, Unit::kRadian, CoordinateKind::kQuaternion};
}

ConfigurationSpace pose_space() {
  return ConfigurationSpace({{"s", Unit::kRadian, CoordinateKind::kAngle},
                             part("qx"),
                             part("qy"),
                             part("qz"),
                             part("qw")});
}

VecX pose(double angle, const Eigen::Vector3d& phi) {
  const UnitQuaternion q = unit_quaternion(phi);
  return (VecX(5) << angle, q.x, q.y, q.z, q.w).finished();
}

VecX difference(const VecX& x, const VecX& x_probe) {
  VecX dx;
  pose_space().difference(x, x_probe, dx);
  return dx;
}

TEST(ConfigurationSpace, ChordFollowsTheQuarterAnglesSine) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.5).normalized();
  const Eigen::Vector3d from(0.3, -0.4, 0.2);
  for (const double theta : {1e-9, 1e-3, 0.5, 1.0, 2.0, 3.0, kPi - 1e-9}) {
    // From the identity, and by symmetry from anywhere.
    EXPECT_NEAR(2 * difference(pose(0, theta * axis), pose(0, {0, 0, 0})).norm(),
                4 * std::sin(theta / 4), 1e-15);
    EXPECT_NEAR(2 * difference(pose(0, from + theta * from.normalized()), pose(0, from)).norm(),
                4 * std::sin(theta / 4), 1e-14);
  }
}

/// tests/report/STUDY.md#half-turns.
TEST(ConfigurationSpace, QuaternionSignFlipIsNoJump) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> within(-3, 3);
  for (int trial = 0; trial < 1000; ++trial) {
    const VecX x = pose(0.1, {within(random), within(random), within(random)});
    const VecX probe = pose(0.2, {within(random), within(random), within(random)});
    VecX flipped = x;
    flipped.tail<4>() *= -1.0;
    EXPECT_EQ(difference(flipped, probe), difference(x, probe));
    EXPECT_LE(difference(x, probe).tail<4>().norm(), std::sqrt(2.0) + 1e-15)
        << "never the long way";
  }
}

/// tests/report/STUDY.md#half-turns.
TEST(ConfigurationSpace, RotationsByPiAreFinite) {
  for (const double theta : {kPi - 1e-9, kPi, kPi + 1e-9}) {
    const VecX dx = difference(pose(0, {theta, 0, 0}), pose(0, {0, 0, 0}));
    EXPECT_TRUE(dx.allFinite());
    EXPECT_NEAR(dx.tail<4>().norm(), std::sqrt(2.0), 1e-9);
  }
}

TEST(ConfigurationSpace, AProxyNeedNotBeNormalised) {
  const VecX probe = pose(0, {0.1, 0.2, 0.3});
  VecX x = pose(0, {0.5, -0.2, 0.1});
  const VecX dx = difference(x, probe);
  x.tail<4>() *= 1.7;
  EXPECT_LT((difference(x, probe) - dx).norm(), 1e-15);
  x.tail<4>().setZero();
  EXPECT_TRUE(difference(x, probe).allFinite());
}

TEST(ConfigurationSpace, TakesTheShorterWayRound) {
  EXPECT_NEAR(difference(pose(3.0, {0, 0, 0}), pose(-3.0, {0, 0, 0}))[0], 6.0 - 2 * kPi, 1e-15);
  EXPECT_EQ(difference(pose(kPi, {0, 0, 0}), pose(0, {0, 0, 0}))[0], kPi);
  EXPECT_EQ(difference(pose(-kPi, {0, 0, 0}), pose(0, {0, 0, 0}))[0], kPi) << "(-pi, pi]";
}

TEST(ConfigurationSpace, QuaternionHasFourConsecutiveParts) {
  EXPECT_EQ(pose_space().quaternions(), std::vector<int>{1});
  EXPECT_THROW(ConfigurationSpace({part("qx"), part("qy"), part("qz")}), SceneError);
  EXPECT_THROW(ConfigurationSpace({part("qx"),
                                   part("qy"),
                                   {"s", Unit::kMetre, CoordinateKind::kLinear},
                                   part("qz"),
                                   part("qw")}),
               SceneError);
  Coordinate in_metres = part("qw");
  in_metres.unit = Unit::kMetre;
  EXPECT_THROW(ConfigurationSpace({part("qx"), part("qy"), part("qz"), in_metres}), SceneError);
}

}  // namespace
}  // namespace haptic::core
