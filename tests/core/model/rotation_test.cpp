#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/core/model/unit_quaternion.hpp"
#include "tests/support/angles.hpp"

namespace haptic::core {
namespace {

TEST(RotationVector, RoundTripsThroughTheQuaternion) {
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  for (const double theta : {0.0, 1e-200, 1e-12, 1e-6, 1e-3, 0.2, 1.0, 3.0, kPi - 1e-7}) {
    Eigen::Vector3d axis(normal(random), normal(random), normal(random));
    const Eigen::Vector3d phi = theta * axis.normalized();
    UnitQuaternion q = unit_quaternion(phi);
    EXPECT_NEAR(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, 1.0, 1e-15);
    EXPECT_LE((rotation_vector(q) - phi).norm(), 1e-15 + 1e-15 * theta);
    q = {-3 * q.x, -3 * q.y, -3 * q.z, -3 * q.w};  // the same rotation
    EXPECT_LE((rotation_vector(q) - phi).norm(), 1e-15 + 1e-15 * theta);
  }
  EXPECT_EQ(rotation_vector({0, 0, 0, 0}), Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(rotation_vector({NAN, 0, 0, 1}), Eigen::Vector3d(0, 0, 0));
}

/// tests/report/STUDY.md#an-hour-of-ticks: a tracker's quaternion is taken as it comes, a million
/// times over.
TEST(RotationVector, MillionReadingsDoNotDrift) {
  Eigen::Vector3d phi(0.3, -0.2, 0.1);
  for (int i = 0; i < 1'000'000; ++i) phi = rotation_vector(unit_quaternion(phi));
  EXPECT_LT((phi - Eigen::Vector3d(0.3, -0.2, 0.1)).norm(), 1e-12);
}

TEST(RotationVector, FollowsATurnThroughPi) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 3).normalized();
  Eigen::Vector3d last = 0.0 * axis;
  for (int i = 0; i <= 900; ++i) {
    const double theta = 0.01 * i;
    const Eigen::Vector3d reading = rotation_vector(unit_quaternion(theta * axis));
    EXPECT_LE(reading.norm(), kPi + 1e-15);
    last = nearest_rotation_vector(reading, last);
    EXPECT_LT((last - theta * axis).norm(), 1e-9);
    // At whole turns any axis will do: the reading has none, and the nearest is not along it.
    if (std::abs(std::remainder(theta, 2 * kPi)) < 0.01) last = theta * axis;
  }
}

}  // namespace
}  // namespace haptic::core
