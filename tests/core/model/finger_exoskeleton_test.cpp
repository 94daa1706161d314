#include "haptic/core/model/finger_exoskeleton.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "haptic/core/error.hpp"
#include "tests/core/model/derivatives.hpp"
#include "tests/core/model/nearest_pose.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/message_of.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

/// core/METHOD.md#finger-linkage, valid region: limits of box, sliders and joints.
bool valid(const FingerDimensions& d, const FingerPose& p) {
  return p.status == MapStatus::kOk && p.c1 > d.slider1_lower && p.c1 < d.slider1_upper &&
         p.c2 > d.slider2_lower && p.c2 < d.slider2_upper && p.q_o1 > -0.3 && p.q_o1 < 1.75 &&
         p.q_o2 > -0.3 && p.q_o2 < 2.0;
}

struct Fixture : ::testing::Test {
  FingerDimensions dimensions = finger_sign_change();
  std::unique_ptr<core::FingerExoskeleton> finger = make_finger_exoskeleton(dimensions);
};
using FingerExoskeleton = Fixture;

/// Rules that every linkage keeps.
struct EveryLinkage : ::testing::TestWithParam<FingerDimensions> {
  FingerDimensions dimensions = GetParam();
  std::unique_ptr<core::FingerExoskeleton> finger = make_finger_exoskeleton(dimensions);

  /// Uniform in the box.
  VecQ random_pose(std::mt19937_64& random) const {
    std::uniform_real_distribution<double> l(dimensions.l_x_lower, dimensions.l_x_upper),
        t(dimensions.q_B_lower, dimensions.q_B_upper);
    const double q_B = t(random);
    return two(l(random), q_B);
  }
};
INSTANTIATE_TEST_SUITE_P(Named, EveryLinkage,
                         ::testing::Values(FingerDimensions{}, finger_sign_change()));

/// tests/report/STUDY.md#check-poses: both columns of the table of core/METHOD.md#finger-linkage.
TEST(FingerDimensions, HaveTheirCheckValues) {
  const struct {
    FingerDimensions d;
    double mcp, pip, l_mm, q_B_deg, c1_mm, c2_mm, J[4];
  } table[] = {
      {finger_sign_change(), 0, 0, 0.897, 30.489, 13.28, 29.86, {-45.332, -1.85, 93.498, 1.753}},
      {finger_sign_change(),
       30,
       30,
       15.864,
       -14.806,
       19.31,
       28.10,
       {-47.670, -1.424, 78.460, .484}},
      {finger_sign_change(),
       60,
       70,
       26.976,
       -54.730,
       12.16,
       17.21,
       {-81.598, -2.333, 141.512, 1.09}},
      {{}, 0, 0, 4.158, 46.304, 7.58, 15.41, {-130.701, -2.507, 448.085, 5.168}},
      {{}, 30, 30, 13.409, 4.793, 14.17, 18.41, {-65.442, -1.594, 170.552, 1.610}},
      {{}, 60, 70, 26.383, -36.082, 10.47, 14.41, {-58.787, -2.400, 158.345, 2.623}},
  };
  for (const auto& row : table) {
    SCOPED_TRACE(::testing::Message() << row.mcp << ", " << row.pip << " deg: " << row.l_mm);
    const auto finger = make_finger_exoskeleton(row.d);
    VecQ q;
    ASSERT_EQ(finger->inverse(kDegree * two(row.mcp, row.pip), q), InverseStatus::kExact);
    EXPECT_NEAR(q[0] * 1e3, row.l_mm, 5e-4);
    EXPECT_NEAR(q[1] / kDegree, row.q_B_deg, 5e-4);
    const FingerPose p = finger_pose(row.d, q[0], q[1]);
    EXPECT_NEAR(p.c1 * 1e3, row.c1_mm, 5e-3);
    EXPECT_NEAR(p.c2 * 1e3, row.c2_mm, 5e-3);
    VecX x;
    MatXQ J;
    ASSERT_EQ(finger->evaluate(q, x, J), MapStatus::kOk);
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(J(k / 2, k % 2), row.J[k], 1e-3);
  }
}

TEST_F(FingerExoskeleton, CoordinatesTellThePhalanxBetweenThem) {
  dimensions.proximal_phalanx = 0.047;
  finger = make_finger_exoskeleton(dimensions);
  EXPECT_EQ(finger->space().coordinates()[0].link, 0.047);
  EXPECT_EQ(finger->space().coordinates()[1].link, 0.0);
}

TEST_P(EveryLinkage, JacobianAgreesWithCentralDifferences) {
  std::mt19937_64 random(2);
  double worst = 0.0;
  for (int poses = 0; poses < 2000;) {
    const VecQ q = random_pose(random);
    if (!valid(dimensions, finger_pose(dimensions, q[0], q[1]))) continue;
    ++poses;
    worst = std::max(worst, jacobian_error(*finger, q));
  }
  EXPECT_LT(worst, 2e-7);
}

/// Slopes by q of the sliders' ends, and, by the second derivatives of x, of the branch.
TEST_P(EveryLinkage, ConstraintsAgreeWithCentralDifferences) {
  std::mt19937_64 random(2);
  const double scale[2] = {0.02, 1.0};
  double worst = 0.0;
  int slopes_of_the_branch = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const VecQ q = random_pose(random);
    Constraints here, up, down;
    if (finger->constraints(q, here) != MapStatus::kOk) continue;
    for (int k = 0; k < 2; ++k) {
      VecQ plus = q, minus = q;
      plus[k] += 6e-6 * scale[k];
      minus[k] -= 6e-6 * scale[k];
      if (finger->constraints(plus, up) != MapStatus::kOk) continue;
      if (finger->constraints(minus, down) != MapStatus::kOk) continue;
      for (std::size_t c = 0; c < here.size(); ++c) {
        const double* const slope = here[c].gradient;
        if (slope[0] == 0.0 && slope[1] == 0.0) continue;  // far off
        slopes_of_the_branch += c == 4;
        const double largest = std::hypot(scale[0] * slope[0], scale[1] * slope[1]);
        const double measured = (up[c].room - down[c].room) / (2 * 6e-6);
        worst = std::max(worst, std::abs(measured - scale[k] * slope[k]) / largest);
      }
    }
  }
  EXPECT_GT(slopes_of_the_branch, 100);
  EXPECT_LT(worst, 1e-4);  // near where the linkage ceases to close slopes change fast
}

TEST_P(EveryLinkage, BothClosedFormsAgree) {
  std::mt19937_64 random(3);
  int poses = 0;
  double worst = 0.0, closure = 0.0;
  VecX x;
  MatXQ J;
  while (poses < 100000) {
    const VecQ q = random_pose(random);
    const FingerPose p = finger_pose(dimensions, q[0], q[1]);
    if (!valid(dimensions, p)) continue;
    ++poses;
    closure = std::max(closure, p.closure);
    const VecX wanted = two(p.q_o1, p.q_o2);
    VecQ back;
    ASSERT_EQ(finger->inverse(wanted, back), InverseStatus::kExact);
    ASSERT_EQ(finger->evaluate(back, x, J), MapStatus::kOk);
    worst = std::max(worst, (x - wanted).cwiseAbs().maxCoeff());
    ASSERT_GT(J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0), 0.0);
  }
  EXPECT_LT(worst, 1e-13);
  EXPECT_LT(closure, 1e-15);
}

/// At constant rates of x: J q_dot = x_dot, and J_dot q_dot = -J q_ddot, by central differences of
/// the inverse along the way.
TEST_P(EveryLinkage, FollowsXWithRatesAndAccelerations) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> rate(-3.0, 3.0);
  constexpr double h = 1e-5;
  int poses = 0;
  while (poses < 500) {
    const VecQ q = random_pose(random);
    const FingerPose p = finger_pose(dimensions, q[0], q[1]);
    const double mcp_dot = rate(random);
    const Eigen::Vector2d x(p.q_o1, p.q_o2), x_dot(mcp_dot, rate(random));
    VecQ now, ahead, behind;
    core::FingerExoskeleton::Motion at;
    if (!valid(dimensions, p) || p.c1 < 0.004 || p.c2 < 0.004 ||
        finger->inverse(VecX(x + h * x_dot), ahead) != InverseStatus::kExact ||
        finger->inverse(VecX(x - h * x_dot), behind) != InverseStatus::kExact) {
      continue;
    }
    ++poses;
    ASSERT_EQ(finger->inverse(VecX(x), now), InverseStatus::kExact);
    ASSERT_EQ(finger->follow(x, x_dot, at), InverseStatus::kExact);
    EXPECT_EQ(VecQ(at.q), now);
    const VecQ q_dot = (ahead - behind) / (2.0 * h);
    const VecQ q_ddot = (ahead - 2.0 * now + behind) / (h * h);
    EXPECT_LT((at.J * q_dot - x_dot).norm(), 1e-4 * x_dot.norm());
    EXPECT_LT((at.product + at.J * q_ddot).norm(), 1e-2 * (1.0 + at.product.norm()));
  }
  core::FingerExoskeleton::Motion at;
  EXPECT_EQ(finger->follow({2.2, 1.0}, {0.0, 0.0}, at), InverseStatus::kUnreachable);
}

/// tests/report/STUDY.md#unreachable-proxies.
TEST_F(FingerExoskeleton, UnreachableProxyGivesTheGlobalOptimum) {
  struct Row {
    double mcp, pip, residual_deg, l_mm, q_B_deg;  // 0: no published figure
  };
  constexpr Row kRows[] = {{-0.5, 0.3, 4.87, 10.15, 41.5},
                           {-0.7, 0.35, 16.07, 10.15, 41.5},
                           {-1.0, 0.3, 33.26, 10.15, 41.5},
                           {-0.5, -0.5, 38.66, 1e-9, 32.25},
                           {2.2, 1.0, 0, 0, 0},
                           {0.3, 2.9, 0, 0, 0}};
  for (const Row& row : kRows) {
    SCOPED_TRACE(::testing::Message() << row.mcp << ", " << row.pip);
    VecQ q;
    ASSERT_EQ(finger->inverse(two(row.mcp, row.pip), q), InverseStatus::kUnreachable);
    const FingerPose p = finger_pose(dimensions, q[0], q[1]);
    ASSERT_EQ(p.status, MapStatus::kOk);
    const double residual = std::hypot(p.q_o1 - row.mcp, p.q_o2 - row.pip);
    const NearestPose brute = nearest_pose(dimensions, two(row.mcp, row.pip));
    EXPECT_LE(residual, brute.distance + 1e-6) << "at " << brute.q << ", not " << q;
    if (row.residual_deg > 0.0) {
      // The figures have two digits of a grid: the optimum itself is up to 0.02 deg lower.
      EXPECT_LE(residual / kDegree, row.residual_deg + 0.005);
      EXPECT_NEAR(residual / kDegree, row.residual_deg, 0.02);
      EXPECT_NEAR(q[0] * 1e3, row.l_mm, 0.06);
      EXPECT_NEAR(q[1] / kDegree, row.q_B_deg, 0.006);
    }
    EXPECT_GE(q[0], dimensions.l_x_lower);
    EXPECT_LE(q[0], dimensions.l_x_upper);
    EXPECT_GE(q[1], dimensions.q_B_lower - 1e-12);
    EXPECT_LE(q[1], dimensions.q_B_upper + 1e-12);
    EXPECT_GE(p.c1, dimensions.slider1_lower - 1e-10);
    EXPECT_GE(p.c2, dimensions.slider2_lower - 1e-10);
  }
}

TEST_P(EveryLinkage, AnyProxyEndsWithinTheLimits) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> angle(-4.0, 4.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 5000; ++i) {
    VecX x = two(angle(random), angle(random));
    if (i % 500 == 0) x[0] = nan;
    if (i % 500 == 1) x[1] = 1e300;
    VecQ q;
    static_cast<void>(finger->inverse(x, q));
    const FingerPose p = finger_pose(dimensions, q[0], q[1]);
    ASSERT_EQ(p.status, MapStatus::kOk) << x.transpose();
    ASSERT_TRUE(q[0] >= dimensions.l_x_lower - 1e-12 && q[0] <= dimensions.l_x_upper + 1e-12)
        << q.transpose();
    ASSERT_GE(p.c1, dimensions.slider1_lower - 1e-9) << x.transpose();
    ASSERT_LE(p.c2, dimensions.slider2_upper + 1e-9) << x.transpose();
  }
}

/// core/METHOD.md#map-without-a-value: |D| <= h1.
TEST_F(FingerExoskeleton, ReportsALinkageThatCannotClose) {
  VecX x = two(7, 7);
  MatXQ J = MatXQ::Constant(2, 2, 7);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(finger->evaluate(two(0.02, -101 * kDegree), x, J), MapStatus::kCannotClose);
  EXPECT_EQ(finger->evaluate(two(nan, 0.0), x, J), MapStatus::kCannotClose);
  EXPECT_EQ(x[0], 7) << "left as it was";
  EXPECT_EQ(J(1, 1), 7);
}

TEST_F(FingerExoskeleton, MeanJacobianIsTheWorkspaceAverage) {
  EXPECT_NEAR(finger->mean_actuated_jacobian(), 73.3, 1.0);
}

TEST(FingerDimensions, NamesTheImpossibleDimension) {
  FingerDimensions d = finger_sign_change();
  d.rod1 = -0.001;
  const std::string text =
      haptic::test::message_of<SceneError>([&] { return make_finger_exoskeleton(d); });
  EXPECT_NE(text.find("rod1_m"), std::string::npos) << text;
  d = {};
  d.rod1 = d.rod2 = 0.5;  // longer than everything else: closes nowhere
  EXPECT_THROW(static_cast<void>(make_finger_exoskeleton(d)), SceneError);
}

}  // namespace
}  // namespace haptic::core
