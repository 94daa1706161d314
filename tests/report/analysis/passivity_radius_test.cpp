#include "tests/report/analysis/passivity_radius.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/linear.hpp"
#include "tests/support/angles.hpp"

namespace haptic::core {
namespace {

struct Finger : ::testing::Test {
  std::unique_ptr<Kinematics> finger = make_finger_exoskeleton(finger_sign_change());
  const RenderingImpedance impedance{VecA::Constant(1, 1500.0), MatXX::Identity(2, 2)};

  VecQ pose(double mcp_deg, double pip_deg) const {
    VecX x(2);
    x << mcp_deg * kDegree, pip_deg * kDegree;
    VecQ q;
    EXPECT_EQ(finger->inverse(x, q), InverseStatus::kExact);
    return q;
  }
};
using PassivityRadius = Finger;

/// core/METHOD.md#exact-derivatives: g = S J^{-1} [J_,a J^{-1}], radius 1/||g||, margin 1 + g.dx,
/// by 2 x 2 algebra.
TEST_F(PassivityRadius, LinearisedRadiusIsTheGainsInverse) {
  for (const auto& [mcp, pip] : {std::pair{30.0, 30.0}, {60.0, 70.0}, {10.0, 40.0}}) {
    const VecQ q = pose(mcp, pip);
    VecX x_probe;
    MatXQ J, J_a;
    ASSERT_EQ(finger->evaluate(q, x_probe, J), MapStatus::kOk);
    ASSERT_EQ(finger->second_order(q, 0, J_a), MapStatus::kOk);
    const Eigen::Matrix2d J2 = J, J_a2 = J_a;
    const double det = J2(0, 0) * J2(1, 1) - J2(0, 1) * J2(1, 0);
    Eigen::Matrix2d inverse;
    inverse << J2(1, 1) / det, -J2(0, 1) / det, -J2(1, 0) / det, J2(0, 0) / det;
    const Eigen::RowVector2d g = inverse.row(0) * (J_a2 * inverse);
    const Eigen::Vector2d dx(0.1, -0.05);
    const VecX x = x_probe + dx;
    const auto certificate =
        passivity_certificate(RendererKind::kSubspaceLinear, *finger, q, x, impedance).value();
    EXPECT_NEAR(certificate.radius * g.norm(), 1.0, 1e-9);
    EXPECT_NEAR(certificate.margin, 1.0 + g * dx, 1e-9);
    // The null-space method's is the same length in another direction
    // (core/METHOD.md#exact-derivatives).
    const auto null_space =
        passivity_certificate(RendererKind::kNullSpace, *finger, q, x, impedance).value();
    EXPECT_NEAR(null_space.radius / certificate.radius, 1.0, 1e-9);
  }
}

TEST_F(PassivityRadius, ExactImpedanceVanishesThere) {
  const VecQ q = pose(40, 50);
  for (const RendererKind kind :
       {RendererKind::kStandard, RendererKind::kNullSpace, RendererKind::kSubspaceLinear}) {
    VecX x_probe;
    MatXQ J;
    ASSERT_EQ(finger->evaluate(q, x_probe, J), MapStatus::kOk);
    const double radius =
        passivity_certificate(kind, *finger, q, x_probe, impedance).value().radius;
    double worst = -1e300, worst_inside = -1e300;
    for (int i = 0; i < 3600; ++i) {
      const double angle = 0.1 * i * kDegree;
      VecX dx(2);
      dx << radius * std::cos(angle), radius * std::sin(angle);
      const VecX on = x_probe + dx, inside = x_probe + 0.99 * dx;
      worst = std::max(worst, (*exact_impedance(kind, *finger, q, on, impedance))(0, 0));
      worst_inside =
          std::max(worst_inside, (*exact_impedance(kind, *finger, q, inside, impedance))(0, 0));
    }
    const double at_rest = -(*exact_impedance(kind, *finger, q, x_probe, impedance))(0, 0);
    EXPECT_NEAR(worst / at_rest, 0.0, 1e-4) << name(kind);
    EXPECT_LT(worst_inside, 0.0) << name(kind);
  }
}

}  // namespace
}  // namespace haptic::core
