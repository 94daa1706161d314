// core/METHOD.md#actuator-limits: which saturation is the gradient of a potential, and which pumps
// energy.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "haptic/core/passivity/spring_storage.hpp"

namespace haptic::core {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

const Vector2d kLimit(5.0, 3.0);  // N

struct Work {
  double net{0.0}, moved{0.0};  ///< J; moved: of the magnitude
  Vector2d most{Vector2d::Zero()};
};

/// Of the force law over a circle of deviations d, 6 mm about (4, -1) mm: partly within the limits,
/// partly beyond either or both.
template <typename Law>
Work loop_work(Law law) {
  constexpr int kSteps = 20000;
  const auto d_at = [](int i) {
    const double phase = 2.0 * M_PI * i / kSteps;
    return Vector2d(0.004 + 0.006 * std::cos(phase), -0.001 + 0.006 * std::sin(phase));
  };
  Work work;
  for (int i = 0; i < kSteps; ++i) {
    const Vector2d from = d_at(i), to = d_at(i + 1);
    const Vector2d tau = law(Vector2d(0.5 * (from + to)));
    const double part = tau.dot(to - from);
    work.net += part;
    work.moved += std::abs(part);
    work.most = work.most.cwiseMax(tau.cwiseAbs());
  }
  return work;
}

/// What the tick does where Z_q is diagonal: each actuator is clamped by itself.
TEST(Saturation, TheClampOfADiagonalStiffnessPumpsNothing) {
  SpringStorage spring;
  spring.stiffness = (VecA(2) << 1500.0, 900.0).finished();
  spring.limit = kLimit;
  spring.gain = 1.0;
  const Work work = loop_work([&](const Vector2d& d) { return Vector2d(spring.force(VecA(d))); });
  EXPECT_LT(std::abs(work.net), 1e-7 * work.moved);
  EXPECT_NEAR((work.most - kLimit).norm(), 0.0, 1e-9) << "both were at their limit";
}

/// Why a coupled Z_q needs another: the same clamp has a derivative that is not symmetric.
TEST(Saturation, TheClampOfACoupledStiffnessPumps) {
  const Matrix2d Z = (Matrix2d() << 1500.0, 800.0, 800.0, 900.0).finished();
  const auto clamped = [&](const Vector2d& d) {
    return Vector2d((Z * d).cwiseMin(kLimit).cwiseMax(-kLimit));
  };
  EXPECT_GT(std::abs(loop_work(clamped).net), 1e-3 * loop_work(clamped).moved);
}

/// What the tick does there: scaled along the whole spring, by how far d is in the metric of Z, it
/// is a gradient again and keeps every limit.
TEST(Saturation, ScaledRadiallyACoupledStiffnessPumpsNothing) {
  const Matrix2d Z = (Matrix2d() << 1500.0, 800.0, 800.0, 900.0).finished();
  SpringStorage spring;
  spring.stiffness = Z.diagonal();
  spring.Z_q = Z;
  spring.gain = 1.0;
  spring.hold_within(VecA(kLimit));
  const Work work = loop_work([&](const Vector2d& d) { return Vector2d(spring.force(VecA(d))); });
  EXPECT_LT(std::abs(work.net), 1e-7 * work.moved);
  EXPECT_LE(work.most[0], kLimit[0]);
  EXPECT_LE(work.most[1], kLimit[1]);
}

}  // namespace
}  // namespace haptic::core
