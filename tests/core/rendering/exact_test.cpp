// Eq. (6) by iteration and by cache: core/METHOD.md#projection-algorithm case A, and cases 14, 16,
// 20 of tests/report/STUDY.md#hard-cases.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <random>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/rendering/renderer.hpp"
#include "tests/core/rendering/function_map.hpp"
#include "tests/support/allocation_guard.hpp"
#include "tests/support/angles.hpp"

namespace haptic::core {
namespace {

using samples::FunctionMap;

/// The finger without its closed form: what is left is the iteration.
class FingerByIteration final : public Kinematics {
 public:
  explicit FingerByIteration(
      std::unique_ptr<Kinematics> finger = make_finger_exoskeleton(finger_sign_change()))
      : Kinematics(finger->dofs(), finger->space()), finger_(std::move(finger)) {
    mean_J_a_ = finger_->mean_actuated_jacobian();
  }
  MapStatus evaluate(const VecQ& q, VecX& x, MatXQ& J) const noexcept override {
    ++evaluations;
    return finger_->evaluate(q, x, J);
  }
  MapStatus second_order(const VecQ& q, int k, MatXQ& J_k) const noexcept override {
    return finger_->second_order(q, k, J_k);
  }
  [[nodiscard]] const Kinematics& finger() const { return *finger_; }

  mutable int evaluations{0};

 private:
  std::unique_ptr<Kinematics> finger_;
};

Projection solve(SubspaceExact& exact, const Kinematics& map, const VecQ& q, const VecX& x,
                 bool changed = true) {
  VecX x_probe;
  MatXQ J;
  EXPECT_EQ(map.evaluate(q, x_probe, J), MapStatus::kOk);
  Projection out;
  exact.project(Probe{q, x_probe, J}, x, {}, VecA::Constant(map.layout().n_a(), 1500.0), changed,
                out);
  return out;
}

VecX at_degrees(double mcp, double pip) {
  return (VecX(2) << mcp, pip).finished() * std::numbers::pi / 180.0;
}

/// The PIP angle at which, with the MCP at -30 deg, two poses of the edge are equally near.
double tie(const Kinematics& map, const VecQ& q) {
  double low = 5.0, high = 8.0;
  const auto at = [&](double pip) {
    SubspaceExact exact{ProjectionModel(map)};
    return solve(exact, map, q, at_degrees(-30.0, pip)).q_star[0];
  };
  const double middle = 0.5 * (at(low) + at(high));
  const bool rises = at(high) > at(low);
  for (int i = 0; i < 60; ++i) {
    const double pip = 0.5 * (low + high);
    (rises == (at(pip) > middle) ? high : low) = pip;
  }
  return 0.5 * (low + high);
}

TEST(Branches, NoiseAtATieMovesNothing) {
  const auto map = make_finger_exoskeleton(finger_sign_change());
  VecQ q(2);
  q << 0.004, 0.4;
  const double pip = tie(*map, q);
  SubspaceExact fresh{ProjectionModel(*map)}, other{ProjectionModel(*map)};
  const double below = solve(fresh, *map, q, at_degrees(-30.0, pip - 1e-4)).q_star[0];
  const double above = solve(other, *map, q, at_degrees(-30.0, pip + 1e-4)).q_star[0];
  ASSERT_GT(std::abs(above - below), 0.005) << "a tie";
  SubspaceExact exact{ProjectionModel(*map)};
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, 0.05);
  int on_a_branch = 0;
  solve(exact, *map, q, at_degrees(-30.0, pip - 0.01));
  for (int n = 0; n < 500; ++n) {
    const Projection out = solve(exact, *map, q, at_degrees(-30.0, pip + noise(random)));
    ASSERT_NEAR(out.q_star[0], below, 5e-4) << n;
    on_a_branch += out.between ? 1 : 0;
  }
  EXPECT_GT(on_a_branch, 100) << "and it is said";
}

TEST(Branches, GoesOverInSmallSteps) {
  const auto map = make_finger_exoskeleton(finger_sign_change());
  VecQ q(2);
  q << 0.004, 0.4;
  const double pip = tie(*map, q);
  SubspaceExact exact{ProjectionModel(*map)}, fresh{ProjectionModel(*map)};
  double last = solve(exact, *map, q, at_degrees(-30.0, pip - 0.01)).q_star[0];
  const VecX x = at_degrees(-30.0, pip + 3.0);
  const double there = solve(fresh, *map, q, x).q_star[0];
  ASSERT_GT(std::abs(there - last), 0.005);
  const double step = 0.00101 * (map->dofs()[0].upper - map->dofs()[0].lower);
  int between = 0;
  for (double way = 0.0; way < 3.0; way += 0.01) {
    const Projection out = solve(exact, *map, q, at_degrees(-30.0, pip + way));
    ASSERT_LE(std::abs(out.q_star[0] - last), step + 1e-4) << way;
    last = out.q_star[0];
    between += out.between ? 1 : 0;
  }
  EXPECT_GT(between, 100) << "held on its branch, then on its way";
  EXPECT_NEAR(last, there, 1e-4);
  // A contact that ends half-way leaves nothing of it to the next one.
  solve(exact, *map, q, at_degrees(-30.0, pip - 3.0));
  exact.release();
  EXPECT_NEAR(solve(exact, *map, q, x).q_star[0], there, 1e-9);
}

TEST(Iteration, ReachesTheClosedFormFromNearby) {
  const FingerByIteration map;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> mcp(0.1, 1.1), pip(0.1, 1.3), far(-0.2, 0.2);
  int judged = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const VecX x = (VecX(2) << mcp(random), pip(random)).finished();
    const VecX start = x + (VecX(2) << far(random), far(random)).finished();
    VecQ q, want;
    if (map.finger().inverse(start, q) != InverseStatus::kExact ||
        map.finger().inverse(x, want) != InverseStatus::kExact) {
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

/// Issue 3: solved once per change of the proxy; what is left for the tick is q*_a - q_a.
TEST(ExactMethod, IsSolvedOncePerProxyChange) {
  const FingerByIteration map;
  SubspaceExact exact(map);
  const VecX x = (VecX(2) << 0.4, 0.5).finished();
  VecQ q;
  ASSERT_EQ(map.finger().inverse((VecX(2) << 0.5, 0.6).finished(), q), InverseStatus::kExact);
  VecX x_probe;
  MatXQ J;
  ASSERT_EQ(map.evaluate(q, x_probe, J), MapStatus::kOk);
  const VecA Z_q = VecA::Constant(1, 1500.0);
  Projection first, out;
  exact.project(Probe{q, x_probe, J}, x, {}, Z_q, true, first);
  map.evaluations = 0;
  for (int tick = 0; tick < 100; ++tick) {
    q[0] += 1e-5;
    q[1] -= 1e-4;
    exact.project(Probe{q, x_probe, J}, x, {}, Z_q * (1.0 - 0.001 * tick), false, out);
    ASSERT_EQ(out.q_star, first.q_star) << "to the bit, whatever q and Z_q do";
  }
  EXPECT_EQ(map.evaluations, 0);
  exact.project(Probe{q, x_probe, J}, x + VecX::Constant(2, 0.01), {}, Z_q, true, out);
  EXPECT_GT(map.evaluations, 0);
  EXPECT_NE(out.q_star, first.q_star);
}

/// tests/report/STUDY.md#unreachable-proxies, for the iteration: unreachable proxies end within the
/// cap, in the box, no worse than they began, and are reported.
TEST(Iteration, UnreachableProxiesEndBoundedAndReported) {
  const FingerByIteration map;
  const VecQ seed = (VecQ(2) << 0.004, 0.4).finished();
  VecX x_seed;
  MatXQ J;
  ASSERT_EQ(map.evaluate(seed, x_seed, J), MapStatus::kOk);
  constexpr double kCases[6][2] = {{-0.5, 0.3},  {-0.7, 0.35}, {-1.0, 0.3},
                                   {-0.5, -0.5}, {2.2, 1.0},   {0.3, 2.9}};
  for (const auto& target : kCases) {
    const VecX x = (VecX(2) << target[0], target[1]).finished();
    SubspaceExact exact(map);
    const Projection out = solve(exact, map, seed, x);
    EXPECT_TRUE(out.q_star.allFinite());
    for (int i = 0; i < 2; ++i) {
      const DofSpec& dof = map.dofs()[static_cast<std::size_t>(i)];
      EXPECT_GE(out.q_star[i], dof.lower);
      EXPECT_LE(out.q_star[i], dof.upper);
    }
    EXPECT_LE(out.residual, (x - x_seed).norm());
    EXPECT_TRUE(out.status == ProjectionStatus::kUnreachable ||
                out.status == ProjectionStatus::kCapped)
        << name(out.status);
  }
}

/// x = a R(q): one sensed angle on a full circle.
FunctionMap turntable() {
  std::vector<DofSpec> list = samples::dofs(2, 1, 2.0 * std::numbers::pi);
  return FunctionMap(
      std::move(list), samples::coordinates(2, Unit::kRadian, CoordinateKind::kAngle),
      [](const VecQ& q) { return VecX((VecX(2) << q[0] + 0.5 * q[1], q[1]).finished()); },
      [](const VecQ&) { return MatXQ((MatXQ(2, 2) << 1.0, 0.5, 0.0, 1.0).finished()); });
}

/// tests/report/STUDY.md#half-turns, for angles: half a turn away everything stays finite, and a
/// whole turn more is the same proxy.
TEST(Renderers, HalfTurnFiniteWholeTurnZero) {
  const FunctionMap map = turntable();
  const VecQ q = (VecQ(2) << 0.3, -0.4).finished();
  VecX x_probe;
  MatXQ J;
  ASSERT_EQ(map.evaluate(q, x_probe, J), MapStatus::kOk);
  const VecA Z_q = VecA::Constant(1, 2.0);
  for (const RendererKind kind : {RendererKind::kStandard, RendererKind::kNullSpace,
                                  RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact}) {
    const auto force = [&](const VecX& x) {
      Renderer renderer(kind, map);
      VecX dx;
      map.space().difference(x, x_probe, dx);
      Projection out;
      renderer.project(Probe{q, x_probe, J}, x, dx, Z_q, true, out);
      return Z_q[0] * (out.q_star[0] - q[0]);
    };
    for (const double turn : {kPi - 1e-9, kPi, -kPi, kPi + 1e-9, 1.0}) {
      const VecX x = x_probe + (VecX(2) << turn, 0.2).finished();
      const double tau = force(x);
      EXPECT_TRUE(std::isfinite(tau)) << name(kind);
      EXPECT_LT(std::abs(tau), 20.0) << name(kind);
      if (turn != 1.0) continue;
      EXPECT_NEAR(force(x + VecX::Constant(2, 2.0 * kPi)), tau, 1e-12) << name(kind);
    }
  }
}

TEST(Iteration, AllocatesNothing) {
  const FingerByIteration finger;
  ProjectionSettings settings;
  settings.metric = TaskMetric::from_matrix((Eigen::Matrix2d() << 2.0, 0.5, 0.5, 1.0).finished());
  for (const bool weighed : {false, true}) {
    const ProjectionModel model(finger, weighed ? settings : ProjectionSettings{});
    const VecQ q = (VecQ(2) << 0.02, -0.5).finished();
    const VecX x_probe = VecX::Zero(2), x = VecX::Constant(2, 0.4);
    const MatXQ J = MatXQ::Identity(2, 2);
    const VecA Z_q = VecA::Constant(1, 800.0);
    for (const RendererKind kind : {RendererKind::kStandard, RendererKind::kNullSpace,
                                    RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact}) {
      const test::AllocationGuard allocations;
      Renderer renderer(kind, model);
      Projection out;
      for (int i = 0; i < 10; ++i) renderer.project({q, x_probe, J}, x, x, Z_q, true, out);
      renderer = Renderer(RendererKind::kSubspaceLinear, model);  // as a session may ask for
      EXPECT_EQ(allocations.allocations(), 0u) << name(kind);
    }
  }
}

/// tests/report/STUDY.md#spike-near-the-fold. The linearised method depends on the Jacobian there,
/// Eq. (6) does not.
TEST(ExactMethod, StaysSmallNearTheFold) {
  const std::unique_ptr<Kinematics> finger = make_finger_exoskeleton(finger_sign_change());
  const VecX x = VecX::Zero(2);
  const auto dq_mm = [&](RendererKind kind, double q_B_deg) {
    const VecQ q = (VecQ(2) << 0.5e-3, q_B_deg * kDegree).finished();
    VecX x_probe, dx(2);
    MatXQ J;
    EXPECT_EQ(finger->evaluate(q, x_probe, J), MapStatus::kOk);
    finger->space().difference(x, x_probe, dx);
    Renderer renderer(kind, *finger);
    Projection out;
    renderer.project(Probe{q, x_probe, J}, x, dx, VecA::Ones(1), true, out);
    return 1e3 * (out.q_star[0] - q[0]);
  };
  EXPECT_NEAR(dq_mm(RendererKind::kSubspaceLinear, 40.0), -1.30, 0.01);
  EXPECT_NEAR(dq_mm(RendererKind::kSubspaceLinear, 49.7), -279.0, 1.0);
  for (int i = 0; i <= 97; ++i) {
    EXPECT_NEAR(dq_mm(RendererKind::kSubspaceExact, 40.0 + 0.1 * i), 0.397, 1e-3);
  }
}

}  // namespace
}  // namespace haptic::core
