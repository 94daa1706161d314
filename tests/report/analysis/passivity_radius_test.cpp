#include "tests/report/analysis/passivity_radius.hpp"

#include <gtest/gtest.h>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

/// core/METHOD.md#exact-derivatives: g = S J^{-1} [J_,a J^{-1}], radius 1/||g||, margin 1 + g.dx,
/// by 2 x 2 algebra.
TEST(PassivityRadius, LinearisedRadiusIsTheGainsInverse) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  const RenderingImpedance impedance{VecA::Constant(1, 1500.0), MatXX::Identity(2, 2)};
  for (const auto& [mcp, pip] : {std::pair{30.0, 30.0}, {60.0, 70.0}, {10.0, 40.0}}) {
    VecQ q;
    ASSERT_EQ(finger->inverse(two(mcp * kDegree, pip * kDegree), q), InverseStatus::kExact);
    VecX x_probe;
    MatXQ J, J_minus, J_plus;
    ASSERT_EQ(finger->evaluate(q, x_probe, J), MapStatus::kOk);
    const VecQ step = 2e-7 * VecQ::Unit(2, 0);
    VecX beside;
    ASSERT_EQ(finger->evaluate(q - step, beside, J_minus), MapStatus::kOk);
    ASSERT_EQ(finger->evaluate(q + step, beside, J_plus), MapStatus::kOk);
    const MatXQ J_a = (J_plus - J_minus) / 4e-7;
    const Eigen::Matrix2d J2 = J, J_a2 = J_a;
    const double det = J2(0, 0) * J2(1, 1) - J2(0, 1) * J2(1, 0);
    Eigen::Matrix2d inverse;
    inverse << J2(1, 1) / det, -J2(0, 1) / det, -J2(1, 0) / det, J2(0, 0) / det;
    const Eigen::RowVector2d g = inverse.row(0) * (J_a2 * inverse);
    const Eigen::Vector2d dx(0.1, -0.05);
    const VecX x = x_probe + dx;
    const auto certificate =
        passivity_certificate(RendererKind::kSubspaceLinear, *finger, q, x, impedance).value();
    // The rounding of both central differences allows no more.
    EXPECT_NEAR(certificate.radius * g.norm(), 1.0, 1e-8);
    EXPECT_NEAR(certificate.margin, 1.0 + g * dx, 1e-8);
    // The null-space method's is the same length in another direction
    // (core/METHOD.md#exact-derivatives).
    const auto null_space =
        passivity_certificate(RendererKind::kNullSpace, *finger, q, x, impedance).value();
    EXPECT_NEAR(null_space.radius / certificate.radius, 1.0, 1e-9);
  }
}

}  // namespace
}  // namespace haptic::core
