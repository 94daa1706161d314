#include "haptic/core/rendering/monotone_envelope.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/rendering/renderer.hpp"
#include "tests/support/allocation_guard.hpp"
#include "tests/support/angles.hpp"

namespace haptic::core {
namespace {

VecX degrees(double mcp, double pip) {
  return (VecX(2) << mcp * kDegree, pip * kDegree).finished();
}

class MonotoneEnvelopeTest : public ::testing::Test {
 protected:
  /// The exact method's anchor from `at` towards `proxy`, and the envelope's.
  EnvelopeAnswer apply(const VecX& at, const VecX& proxy,
                       RendererKind kind = RendererKind::kSubspaceExact) {
    EXPECT_EQ(finger->inverse(at, q), InverseStatus::kExact);
    EXPECT_EQ(finger->evaluate(q, x_probe, J), MapStatus::kOk);
    finger->space().difference(proxy, x_probe, dx);
    Renderer renderer(kind, *finger);
    renderer.project(Probe{q, x_probe, J}, proxy, dx, VecA::Constant(1, 1500.0), true, wanted);
    used = wanted;
    return envelope.apply(Probe{q, x_probe, J}, dx, kind, used);
  }
  /// S J^+ dx by the test's own inverse.
  [[nodiscard]] double towards() const {
    const double det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
    return (J(1, 1) * dx[0] - J(0, 1) * dx[1]) / det;
  }
  [[nodiscard]] double pull(const Projection& p) const { return p.q_star[0] - q[0]; }

  std::unique_ptr<Kinematics> finger = make_finger_exoskeleton(finger_sign_change());
  MonotoneEnvelope envelope{*finger};
  VecQ q{};
  VecX x_probe{}, dx{};
  MatXQ J{};
  Projection wanted{}, used{};
};

TEST_F(MonotoneEnvelopeTest, MonotoneWayGivesTheExactBits) {
  EXPECT_EQ(apply(degrees(30, 40), degrees(18, 25)), EnvelopeAnswer::kProxy);
  EXPECT_EQ(used.q_star, wanted.q_star);
}

TEST_F(MonotoneEnvelopeTest, PulledAwayItUsesEarlierPoints) {
  // core/METHOD.md#forces-at-the-finger: MCP blocked at 18 deg, PIP free at 52 deg: x* pulls the
  // wrong way.
  EXPECT_EQ(apply(degrees(50, 52), degrees(18, 52)), EnvelopeAnswer::kEarlier);
  EXPECT_LT(pull(wanted) * towards(), 0.0);
  EXPECT_GT(pull(used) * towards(), 0.0);
  // q*_a(s) over 200 points by the closed form: the envelope is its maximum, seen at three points.
  double most = 0.0;
  for (int k = 1; k <= 200; ++k) {
    VecQ q_star = q;
    ASSERT_EQ(finger->inverse(x_probe + (k / 200.0) * dx, q_star), InverseStatus::kExact);
    most = std::max(most, (q_star[0] - q[0]) * (towards() < 0.0 ? -1.0 : 1.0));
  }
  EXPECT_LE(std::abs(pull(used)), most + 1e-6);
  EXPECT_GT(std::abs(pull(used)), 0.8 * most);
}

TEST_F(MonotoneEnvelopeTest, NeverPointsAwayFromTheProxy) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> mcp(15.0, 70.0), pip(5.0, 90.0);
  int earlier = 0, withheld = 0;
  for (int n = 0; n < 3000; ++n) {
    for (const RendererKind kind : {RendererKind::kStandard, RendererKind::kNullSpace,
                                    RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact}) {
      const VecX at = degrees(mcp(random), pip(random)), proxy = degrees(mcp(random), pip(random));
      const EnvelopeAnswer answer = apply(at, proxy, kind);
      earlier += answer == EnvelopeAnswer::kEarlier ? 1 : 0;
      withheld += answer == EnvelopeAnswer::kWithheld ? 1 : 0;
      if (answer == EnvelopeAnswer::kWithheld) continue;
      ASSERT_GE(pull(used) * towards(), 0.0);
      ASSERT_GE(std::abs(pull(used)), std::abs(pull(wanted)) * (pull(wanted) * towards() > 0.0));
      ASSERT_TRUE(used.q_star.allFinite());
    }
  }
  EXPECT_GT(earlier, 20);
  EXPECT_GT(withheld, 20) << "the standard method has no earlier point to offer";
}

TEST_F(MonotoneEnvelopeTest, ProportionalProjectionsKeepTheirProxy) {
  for (const RendererKind kind : {RendererKind::kNullSpace, RendererKind::kSubspaceLinear}) {
    EXPECT_EQ(apply(degrees(50, 52), degrees(18, 52), kind), EnvelopeAnswer::kProxy);
    EXPECT_EQ(used.q_star, wanted.q_star);
  }
}

TEST_F(MonotoneEnvelopeTest, PullsNothingAtTheProxy) {
  apply(degrees(30, 30), degrees(30, 30));
  EXPECT_NEAR(pull(used), 0.0, 1e-14);
}

TEST_F(MonotoneEnvelopeTest, AllocatesNothing) {
  apply(degrees(50, 52), degrees(18, 52));
  used = wanted;
  const haptic::test::AllocationGuard guard;
  static_cast<void>(envelope.apply(Probe{q, x_probe, J}, dx, RendererKind::kSubspaceExact, used));
  EXPECT_EQ(guard.allocations(), 0u);
}

}  // namespace
}  // namespace haptic::core
