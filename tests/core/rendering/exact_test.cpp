// Eq. (6) by iteration and by cache: core/METHOD.md#projection-algorithm case A, and cases 14, 16,
// 20 of tests/report/STUDY.md#hard-cases.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <random>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/core/model/sample_maps.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

/// The finger with its closed form, and without: what is left is the iteration.
const Kinematics& closed_form() {
  static const auto finger = make_finger_exoskeleton(finger_sign_change());
  return *finger;
}
const samples::Wrapped& by_iteration() {
  static const samples::Wrapped map(closed_form());
  return map;
}

Projection solve(SubspaceExact& exact, const Kinematics& map, const VecQ& q, const VecX& x) {
  return projected(exact, Instant(map, q, x), VecA::Constant(map.layout().n_a(), 1500.0));
}

VecX at_degrees(double mcp, double pip) {
  return kDegree * two(mcp, pip);
}

/// q*_a with the MCP at -30 deg and the PIP at `pip`, from `q`, and after what `exact` saw before.
Projection beyond(SubspaceExact& exact, double pip) {
  return solve(exact, closed_form(), two(0.004, 0.4), at_degrees(-30.0, pip));
}
double freshly_beyond(double pip) {
  SubspaceExact exact{ProjectionModel(closed_form())};
  return beyond(exact, pip).q_star[0];
}

/// The PIP angle at which two poses of the edge are equally near.
double tie() {
  double low = 5.0, high = 8.0;
  const auto at = freshly_beyond;
  const double middle = 0.5 * (at(low) + at(high));
  const bool rises = at(high) > at(low);
  for (int i = 0; i < 60; ++i) {
    const double pip = 0.5 * (low + high);
    (rises == (at(pip) > middle) ? high : low) = pip;
  }
  return 0.5 * (low + high);
}

TEST(Branches, NoiseAtATieMovesNothing) {
  const double pip = tie(), below = freshly_beyond(pip - 1e-4);
  ASSERT_GT(std::abs(freshly_beyond(pip + 1e-4) - below), 0.005) << "a tie";
  SubspaceExact exact{ProjectionModel(closed_form())};
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, 0.05);
  int on_a_branch = 0;
  beyond(exact, pip - 0.01);
  for (int n = 0; n < 500; ++n) {
    const Projection out = beyond(exact, pip + noise(random));
    ASSERT_NEAR(out.q_star[0], below, 5e-4) << n;
    on_a_branch += out.between ? 1 : 0;
  }
  EXPECT_GT(on_a_branch, 100) << "and it is said";
}

TEST(Branches, GoesOverInSmallSteps) {
  const double pip = tie(), there = freshly_beyond(pip + 3.0);
  SubspaceExact exact{ProjectionModel(closed_form())};
  double last = beyond(exact, pip - 0.01).q_star[0];
  ASSERT_GT(std::abs(there - last), 0.005);
  const DofSpec& l_x = closed_form().dofs()[0];
  int between = 0;
  for (double way = 0.0; way < 3.0; way += 0.01) {
    const Projection out = beyond(exact, pip + way);
    ASSERT_LE(std::abs(out.q_star[0] - last), 0.00101 * (l_x.upper - l_x.lower) + 1e-4) << way;
    last = out.q_star[0];
    between += out.between ? 1 : 0;
  }
  EXPECT_GT(between, 100) << "held on its branch, then on its way";
  EXPECT_NEAR(last, there, 1e-4);
  // A contact that ends half-way leaves nothing of it to the next one.
  beyond(exact, pip - 3.0);
  exact.release();
  EXPECT_NEAR(beyond(exact, pip + 3.0).q_star[0], there, 1e-9);
}

TEST(Iteration, ReachesTheClosedFormFromNearby) {
  const Kinematics& map = by_iteration();
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> mcp(0.1, 1.1), pip(0.1, 1.3), far(-0.2, 0.2);
  int judged = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const VecX x = two(mcp(random), pip(random));
    const VecX start = x + two(far(random), far(random));
    VecQ q, want;
    if (closed_form().inverse(start, q) != InverseStatus::kExact ||
        closed_form().inverse(x, want) != InverseStatus::kExact) {
      continue;
    }
    ++judged;
    SubspaceExact exact(map);
    const Projection out = solve(exact, map, q, x);
    EXPECT_EQ(out.status, ProjectionStatus::kConverged);
    EXPECT_LT(std::abs(out.q_star[0] - want[0]), 1e-12);  // m
    EXPECT_LT(std::abs(out.q_star[1] - want[1]), 1e-11);  // rad
    EXPECT_LT(out.residual, 1e-12);
  }
  EXPECT_GT(judged, 300);
}

/// Solved once per change of the proxy; what is left for the tick is q*_a - q_a.
TEST(ExactMethod, IsSolvedOncePerProxyChange) {
  const samples::Wrapped& map = by_iteration();
  SubspaceExact exact(map);
  const VecX x = two(0.4, 0.5);
  VecQ q;
  ASSERT_EQ(closed_form().inverse(two(0.5, 0.6), q), InverseStatus::kExact);
  Instant at(map, q, x);
  const Projection first = projected(exact, at, one(1500.0));
  map.evaluations = 0;
  for (int tick = 0; tick < 100; ++tick) {
    at.q += two(1e-5, -1e-4);
    const Projection out = projected(exact, at, one(1500.0 * (1.0 - 0.001 * tick)), false);
    ASSERT_EQ(out.q_star, first.q_star) << "to the bit, whatever q and Z_q do";
  }
  EXPECT_EQ(map.evaluations, 0);
  at.x += two(0.01, 0.01);
  EXPECT_NE(projected(exact, at, one(1500.0)).q_star, first.q_star);
  EXPECT_GT(map.evaluations, 0);
}

/// tests/report/STUDY.md#unreachable-proxies, for the iteration: unreachable proxies end within the
/// cap, in the box, no worse than they began, and are reported.
TEST(Iteration, UnreachableProxiesEndBoundedAndReported) {
  const Kinematics& map = by_iteration();
  const VecQ seed = two(0.004, 0.4);
  constexpr double kCases[6][2] = {{-0.5, 0.3},  {-0.7, 0.35}, {-1.0, 0.3},
                                   {-0.5, -0.5}, {2.2, 1.0},   {0.3, 2.9}};
  for (const auto& target : kCases) {
    const Instant at(map, seed, two(target[0], target[1]));
    SubspaceExact exact(map);
    const Projection out = projected(exact, at, one(1500.0));
    EXPECT_TRUE(out.q_star.allFinite());
    for (int i = 0; i < 2; ++i) {
      const DofSpec& dof = map.dofs()[static_cast<std::size_t>(i)];
      EXPECT_GE(out.q_star[i], dof.lower);
      EXPECT_LE(out.q_star[i], dof.upper);
    }
    EXPECT_LE(out.residual, at.dx.norm());
    EXPECT_TRUE(out.status == ProjectionStatus::kUnreachable ||
                out.status == ProjectionStatus::kCapped)
        << static_cast<int>(out.status);
  }
}

/// tests/report/STUDY.md#half-turns, for angles: half a turn away everything stays finite, and a
/// whole turn more is the same proxy.
TEST(Renderers, HalfTurnFiniteWholeTurnZero) {
  LinearMap turntable = samples::linear_parameters(
      (Eigen::Matrix2d() << 1.0, 0.5, 0.0, 1.0).finished(), 1, 2.0 * kPi, Unit::kRadian);
  for (Coordinate& angle : turntable.coordinates) angle.kind = CoordinateKind::kAngle;
  const auto map = make_linear(turntable);
  const VecQ q = two(0.3, -0.4);
  const VecX x_probe = two(0.1, -0.4);
  for (const RendererKind kind : kEveryRenderer) {
    const auto force = [&](const VecX& x) {
      return first_force(kind, *map, Instant(*map, q, x), one(2.0))[0];
    };
    for (const double turn : {kPi - 1e-9, kPi, -kPi, kPi + 1e-9, 1.0}) {
      const VecX x = x_probe + two(turn, 0.2);
      const double tau = force(x);
      EXPECT_TRUE(std::isfinite(tau)) << name(kind);
      EXPECT_LT(std::abs(tau), 20.0) << name(kind);
      if (turn != 1.0) continue;
      EXPECT_NEAR(force(x + VecX::Constant(2, 2.0 * kPi)), tau, 1e-12) << name(kind);
    }
  }
}

/// tests/report/STUDY.md#spike-near-the-fold. The linearised method depends on the Jacobian there,
/// Eq. (6) does not.
TEST(ExactMethod, StaysSmallNearTheFold) {
  const auto dq_mm = [&](RendererKind kind, double q_B_deg) {
    const Instant at(closed_form(), two(0.5e-3, q_B_deg * kDegree), two(0.0, 0.0));
    return 1e3 * first_force(kind, closed_form(), at, one(1.0))[0];
  };
  EXPECT_NEAR(dq_mm(RendererKind::kSubspaceLinear, 40.0), -1.30, 0.01);
  EXPECT_NEAR(dq_mm(RendererKind::kSubspaceLinear, 49.7), -279.0, 1.0);
  for (int i = 0; i <= 97; ++i) {
    EXPECT_NEAR(dq_mm(RendererKind::kSubspaceExact, 40.0 + 0.1 * i), 0.397, 1e-3);
  }
}

}  // namespace
}  // namespace haptic::core
