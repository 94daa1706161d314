/// The soft finger of the soft-grasp example: its energy, its contact, its proxy.

#include "soft_finger.hpp"
#include "tests/support/angles.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

namespace haptic::examples {
namespace {

/// Poses over the motion that the example is made for: MCP 0..60, PIP 0..70 degrees.
template <typename Visit>
void over_the_motion(Visit visit) {
  for (int mcp = 0; mcp <= 60; mcp += 5) {
    for (int pip = 0; pip <= 70; pip += 5) visit(Joints{mcp * kDegree, pip * kDegree});
  }
}

/// Depth of the deepest pad by the kinematics of core/METHOD.md#finger-linkage in complex numbers.
double depth_by_complex_numbers(const SoftFingerModel& m, const Joints& x) {
  using Complex = std::complex<double>;
  const Complex u1 = std::polar(1.0, -x[0]), u2 = std::polar(1.0, -(x[0] + x[1]));
  const Complex palmar(0.0, -1.0), centre(m.centre_x, m.centre_y);
  double deepest = -1.0;
  for (int i = 1; i <= SoftFinger::kPadsPerPhalanx; ++i) {
    const double part = static_cast<double>(i) / SoftFinger::kPadsPerPhalanx;
    const Complex first = (part * m.proximal + palmar * m.pad_depth) * u1;
    const Complex second = m.proximal * u1 + (part * m.distal + palmar * m.pad_depth) * u2;
    deepest = std::max(
        {deepest, m.radius - std::abs(first - centre), m.radius - std::abs(second - centre)});
  }
  return deepest;
}

TEST(SoftFinger, PadsFollowTheMethodsKinematics) {
  const SoftFingerModel model;
  const SoftFinger finger(model);
  over_the_motion([&](const Joints& x) {
    EXPECT_NEAR(finger.contact(x).depth, depth_by_complex_numbers(model, x), 1e-15);
  });
}

TEST(SoftFinger, GradientIsTheEnergysDifference) {
  const SoftFinger finger;
  constexpr double h = 1e-6;
  over_the_motion([&](const Joints& x) {
    const auto energy = finger.contact(x);
    for (std::size_t k = 0; k < 2; ++k) {
      Joints up = x, down = x;
      up[k] += h;
      down[k] -= h;
      const double difference = (finger.contact(up).value - finger.contact(down).value) / (2.0 * h);
      // Energies reach a few J; a pad crossing the surface within h adds its k depth^2 / h.
      EXPECT_NEAR(energy.gradient[k], difference, 1e-6) << x[0] << ' ' << x[1];
    }
  });
}

TEST(SoftFinger, TheHessianKeepsNewtonGoingDownhill) {
  const SoftFinger finger;
  over_the_motion([&](const Joints& x) {
    const auto [h11, h12, h22] = finger.contact(x).hessian;  // one off-diagonal: symmetric by type
    EXPECT_GE(h11, 0.0);
    EXPECT_GE(h22, 0.0);
    EXPECT_GE(h11 * h22 - h12 * h12, -1e-9 * (1.0 + h11 * h22));
  });
}

TEST(SoftFinger, OnlyContactOpensTheFinger) {
  int touching = 0, apart = 0;
  over_the_motion([&](const Joints& probe) {
    SoftFinger finger;
    const double depth = finger.contact(probe).depth;
    const auto step = finger.step(probe);
    ++(step.touching ? touching : apart);
    if (step.touching) {
      EXPECT_LE(step.x[0] + step.x[1], probe[0] + probe[1]) << probe[0] << ' ' << probe[1];
    } else {
      EXPECT_LE(depth, 0.0) << probe[0] << ' ' << probe[1];
      EXPECT_EQ(step.x, probe);
      EXPECT_EQ(step.energy, 0.0);
    }
  });
  EXPECT_LT(SoftFinger().contact({0.0, 0.0}).depth, 0.0) << "the open hand touches nothing";
  EXPECT_TRUE(touching > 0 && apart > 0);
}

TEST(SoftFinger, PushedThroughProbeStaysInContact) {
  SoftFinger finger;
  const auto pose = [](int percent) {
    return Joints{0.6 * percent * kDegree, 0.7 * percent * kDegree};
  };
  ASSERT_LT(finger.contact(pose(100)).depth, 0.0)
      << "the fist is behind the object, or this tests nothing";
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

/// As when it had been there from the start.
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
    EXPECT_TRUE(std::isfinite(step.x[0]) && std::isfinite(step.energy)) << odd;
  }
}

TEST(SoftFinger, TheProxyIsAnEquilibrium) {
  const SoftFingerModel model;
  SoftFinger finger(model);
  for (int percent = 0; percent <= 100; ++percent) {  // closing steadily, as a hand does
    const Joints probe{0.6 * percent * kDegree, 0.7 * percent * kDegree};
    const auto step = finger.step(probe);
    if (!step.touching) continue;
    const auto contact = finger.contact(step.x);
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_NEAR(contact.gradient[k] + model.coupling * (step.x[k] - probe[k]), 0.0, 1e-7)
          << percent;
    }
  }
}

TEST(SoftFinger, ItsContactsHaveItsEnergy) {
  const SoftFingerModel model;
  const SoftFinger finger(model);
  over_the_motion([&](const Joints& x) {
    double value = 0.0, near = 1.0;
    Joints gradient{};
    const auto planes = finger.contacts(x, 0.03);
    for (const client::Plane& plane : planes) {
      EXPECT_EQ(plane.compliance, model.coupling / model.pad_stiffness);
      const double gap = plane.offset - plane.normal[0] * x[0] - plane.normal[1] * x[1];
      EXPECT_LE(gap, 0.03);
      near = std::min(near, gap);
      if (gap >= 0.0) continue;
      value += 0.5 * model.pad_stiffness * gap * gap;
      for (std::size_t k = 0; k < 2; ++k)
        gradient[k] -= model.pad_stiffness * gap * plane.normal[k];
    }
    const auto energy = finger.contact(x);
    EXPECT_NEAR(value, energy.value, 1e-15);
    for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(gradient[k], energy.gradient[k], 1e-13);
    EXPECT_EQ(planes.empty(), energy.depth < -0.03);
    EXPECT_NEAR(near, planes.empty() ? 1.0 : -energy.depth, 1e-15);
  });
}

TEST(SoftFinger, ContactEndsWithSomeClearance) {
  const SoftFinger probe_only;
  SoftFinger finger;
  const auto pose = [](double degrees) { return Joints{degrees * kDegree, degrees * kDegree}; };
  double touch = 0.0;  // closing: the first pose in contact
  while (probe_only.contact(pose(touch)).depth <= 0.0) touch += 0.001;
  ASSERT_LT(touch, 60.0);
  EXPECT_FALSE(finger.step(pose(touch - 0.001)).touching);
  EXPECT_TRUE(finger.step(pose(touch)).touching);
  EXPECT_TRUE(finger.step(pose(touch - 0.001)).touching) << "noise must not toggle the mode";
  EXPECT_FALSE(finger.step(pose(0.0)).touching);
}

}  // namespace
}  // namespace haptic::examples
