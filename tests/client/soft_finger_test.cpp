/// The soft finger of the soft-grasp example: its contacts, its proxy.

#include "soft_finger.hpp"
#include "tests/support/angles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>

namespace haptic::examples {
namespace {

/// Depth of every pad, by the kinematics of core/METHOD.md#finger-linkage in complex numbers.
std::vector<double> depths_by_complex_numbers(const SoftFingerModel& m, const Joints& x) {
  using Complex = std::complex<double>;
  const Complex u1 = std::polar(1.0, -x[0]), u2 = std::polar(1.0, -(x[0] + x[1]));
  const Complex palmar(0.0, -1.0), centre(m.centre_x, m.centre_y);
  std::vector<double> depths;
  for (int i = 1; i <= SoftFinger::kPadsPerPhalanx; ++i) {
    const double part = static_cast<double>(i) / SoftFinger::kPadsPerPhalanx;
    const Complex first = (part * m.proximal + palmar * m.pad_depth) * u1;
    const Complex second = m.proximal * u1 + (part * m.distal + palmar * m.pad_depth) * u2;
    depths.push_back(m.radius - std::abs(first - centre));
    depths.push_back(m.radius - std::abs(second - centre));
  }
  return depths;
}

double deepest(const SoftFingerModel& m, const Joints& x) {
  const std::vector<double> depths = depths_by_complex_numbers(m, x);
  return *std::max_element(depths.begin(), depths.end());
}

/// Over the motion that the example is made for: MCP 0..60, PIP 0..70 degrees.
TEST(SoftFinger, PadsFollowTheMethodsKinematics) {
  const SoftFinger finger;
  for (int pose = 0; pose < 13 * 15; ++pose) {
    const Joints x{5 * (pose / 15) * kDegree, 5 * (pose % 15) * kDegree};
    EXPECT_NEAR(finger.depth(x), deepest({}, x), 1e-15);
    const auto near = finger.contacts(x, 0.03);
    const std::vector<double> depths = depths_by_complex_numbers({}, x);
    EXPECT_EQ(static_cast<long>(near.size()),
              std::count_if(depths.begin(), depths.end(), [](double d) { return d >= -0.03; }));
    for (const client::Plane& plane : near) {
      const double gap = plane.offset - plane.normal[0] * x[0] - plane.normal[1] * x[1];
      EXPECT_TRUE(std::any_of(depths.begin(), depths.end(),
                              [gap](double depth) { return std::abs(depth + gap) < 1e-15; }));
      EXPECT_EQ(plane.compliance, 0.02 / 400.0);
    }
  }
}

TEST(SoftFinger, PushedThroughProbeStaysInContact) {
  SoftFinger finger;
  const auto pose = [](int percent) {
    return Joints{0.6 * percent * kDegree, 0.7 * percent * kDegree};
  };
  ASSERT_LT(deepest({}, pose(100)), 0.0) << "the fist is behind the object, or this tests nothing";
  bool touched = false;
  for (int percent = 0; percent <= 100; ++percent) {
    const auto step = finger.step(pose(percent));
    EXPECT_TRUE(step.touching || !touched) << "let go while closing, at " << percent << " %";
    touched = touched || step.touching;
    EXPECT_LE(step.x[0], pose(percent)[0] + 1e-12) << "contact can only hold the finger back";
  }
  EXPECT_TRUE(touched);
  for (int percent = 100; percent >= 0; --percent) static_cast<void>(finger.step(pose(percent)));
  EXPECT_FALSE(finger.step(pose(0)).touching);
}

/// The contact is what it is for a client that was there from the start.
TEST(SoftFinger, JoiningInsideMeetsTheKnownSide) {
  SoftFinger steady;
  for (int percent = 0; percent <= 100; ++percent) {
    const Joints probe{0.6 * percent * kDegree, 0.7 * percent * kDegree};
    const auto closed = steady.step(probe);
    SoftFinger late;
    const auto joined = late.step(probe);
    EXPECT_EQ(joined.touching, closed.touching) << percent;
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_NEAR(joined.x[k], closed.x[k], 2.0 * kDegree) << percent;
    }
    static_cast<void>(late.step({0.0, 0.0}));
    EXPECT_FALSE(late.step({0.0, 0.0}).touching);
  }
}

TEST(SoftFinger, OddProbesAreFollowed) {
  SoftFinger finger;
  for (const double odd : {1e6, -1e6, 1e300}) {
    const auto step = finger.step({odd, -odd});
    EXPECT_TRUE(std::isfinite(step.x[0]) && std::isfinite(step.x[1])) << odd;
  }
}

TEST(SoftFinger, ContactEndsWithSomeClearance) {
  SoftFinger finger;
  const auto pose = [](double degrees) { return Joints{degrees * kDegree, degrees * kDegree}; };
  double touch = 0.0;  // closing: the first pose in contact
  while (deepest({}, pose(touch)) <= 0.0) touch += 0.001;
  ASSERT_LT(touch, 60.0);
  EXPECT_FALSE(finger.step(pose(touch - 0.001)).touching);
  EXPECT_TRUE(finger.step(pose(touch)).touching);
  EXPECT_TRUE(finger.step(pose(touch - 0.001)).touching) << "noise must not toggle the mode";
  EXPECT_FALSE(finger.step(pose(0.0)).touching);
}

}  // namespace
}  // namespace haptic::examples
