#include "tests/report/analysis/displayed_impedance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/linear.hpp"
#include "haptic/core/rendering/renderer.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

constexpr RendererKind kAll[] = {RendererKind::kStandard, RendererKind::kNullSpace,
                                 RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact};

/// x = A q with three rows, q0 actuated and q1 not: small enough for pencil and paper.
/// A = [1 1; 0 1; 1 0]: J_a = (1,0,1), J_n = (1,1,0), N J_a = J_a - J_n/2 = (1/2,-1/2,1).
std::unique_ptr<Kinematics> by_hand() {
  LinearMap map;
  map.dofs = {{"a", Unit::kMetre, true, -1, 1}, {"n", Unit::kMetre, false, -1, 1}};
  map.coordinates = {{"x", Unit::kMetre}, {"y", Unit::kMetre}, {"z", Unit::kMetre}};
  map.A = (MatXQ(3, 2) << 1, 1, 0, 1, 1, 0).finished();
  map.x_0 = VecX::Zero(3);
  return make_linear(map);
}

TEST(TheoreticalImpedance, FollowsItsPublishedEquations) {
  const auto map = by_hand();
  RenderingImpedance impedance{VecA::Constant(1, 7.0), MatXX::Identity(3, 3) * 2.0};
  const VecQ q = VecQ::Zero(2);
  const auto at = [&](RendererKind kind) {
    return theoretical_impedance(kind, *map, q, impedance).value();
  };
  // Eq. (2), Z_x = 2 I: -2 (J_a.J_a, J_a.J_n) = -2 (2, 1).
  EXPECT_NEAR(at(RendererKind::kStandard)(0, 0), -4.0, 1e-14);
  EXPECT_NEAR(at(RendererKind::kStandard)(0, 1), -2.0, 1e-14);
  // Eq. (5): -2 (N J_a).(J_a, J_n) = -2 (3/2, 0).
  EXPECT_NEAR(at(RendererKind::kNullSpace)(0, 0), -3.0, 1e-14);
  EXPECT_NEAR(at(RendererKind::kNullSpace)(0, 1), 0.0, 1e-14);
  // Eq. (9): -Z_q S.
  for (const RendererKind kind : {RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact}) {
    EXPECT_EQ(at(kind)(0, 0), -7.0);
    EXPECT_EQ(at(kind)(0, 1), 0.0);
  }
  // A Z_x that is no multiple of I couples the null-space force to q_n, as the paper warns:
  // Z_x = diag(1,2,3): N J_a.(Z_x J_n) = 1/2 - 1 = -1/2; (Z_x J_a) = (1,0,3): 1/2 + 3.
  impedance.Z_x = (VecX(3) << 1, 2, 3).finished().asDiagonal();
  EXPECT_NEAR(at(RendererKind::kNullSpace)(0, 0), -3.5, 1e-14);
  EXPECT_NEAR(at(RendererKind::kNullSpace)(0, 1), 0.5, 1e-14);
}

/// Central differences of what the renderers themselves command.
struct FingerForces : ::testing::Test {
  std::unique_ptr<Kinematics> finger = make_finger_exoskeleton(finger_sign_change());
  const double Z_q = 1500.0;
  RenderingImpedance impedance{VecA::Constant(1, Z_q), {}};

  FingerForces() {
    const double mean = finger->mean_actuated_jacobian();
    impedance.Z_x = MatXX::Identity(2, 2) * (Z_q / (mean * mean));
  }
  double tau(RendererKind kind, const VecQ& q, const VecX& x) const {
    VecX x_probe;
    MatXQ J;
    EXPECT_EQ(finger->evaluate(q, x_probe, J), MapStatus::kOk);
    const VecX dx = x - x_probe;
    Renderer renderer(kind, *finger);
    Projection out;
    renderer.project(Probe{q, x_probe, J}, x, dx, impedance.Z_q, true, out);
    return Z_q * (out.q_star[0] - q[0]);
  }
};

TEST_F(FingerForces, AnalyticDerivativesAreTheForces) {
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> mcp(0.1, 1.1), pip(0.1, 1.3);
  const double h[2] = {2e-7, 1e-5};  // m, rad
  for (int i = 0; i < 300; ++i) {
    const VecX x = two(mcp(random), pip(random));
    VecQ q, q_star;
    ASSERT_EQ(finger->inverse(two(mcp(random), pip(random)), q), InverseStatus::kExact);
    ASSERT_EQ(finger->inverse(x, q_star), InverseStatus::kExact);
    for (const RendererKind kind : kAll) {
      const MatAQ exact = exact_impedance(kind, *finger, q, x, impedance).value();
      const MatAX gain = proxy_gain(kind, *finger, q, x, q_star, impedance).value();
      for (int k = 0; k < 2; ++k) {
        const VecQ dq = VecQ::Unit(2, k) * h[k];
        const double slope = (tau(kind, q + dq, x) - tau(kind, q - dq, x)) / (2.0 * h[k]);
        const double scale = k == 0 ? Z_q : Z_q * 0.02;  // per rad: l_x moves by 20 mm/rad or so
        EXPECT_NEAR(exact(0, k), slope, 2e-5 * (std::abs(slope) + scale)) << name(kind) << k;
        const VecX dx = VecX::Unit(2, k) * 1e-6;
        const double slope_x = (tau(kind, q, x + dx) - tau(kind, q, x - dx)) / 2e-6;
        EXPECT_NEAR(gain(0, k), slope_x, 1e-4 * (std::abs(slope_x) + 1.0)) << name(kind) << k;
      }
    }
  }
}

}  // namespace
}  // namespace haptic::core
