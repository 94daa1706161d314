// The paper's Fig. 4 with the metrics of
// tests/report/STUDY.md#finite-difference-rule-finger_sign_change: cases 7, 8 and 9 of
// tests/report/STUDY.md#hard-cases, all unguarded.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/rendering/renderer.hpp"
#include "tests/report/analysis/trajectory_metrics.hpp"
#include "tests/support/angles.hpp"

namespace haptic::core {
namespace {

TrajectoryAnalysis analysis(const Kinematics& finger, double A1, double A2, double psi) {
  GraspCycle grasp;
  grasp.A1 = A1 * kDegree;
  grasp.A2 = A2 * kDegree;
  grasp.psi = psi * kDegree;
  return TrajectoryAnalysis(finger, sampled(finger, grasp), VecX::Zero(2), 1.0);
}

/// tests/report/STUDY.md#finite-difference-rule-finger_sign_change, the table of trajectory A;
/// every entry within 0.05.
TEST(TrajectoryA, ReproducesTheTable) {
  struct Row {
    RendererKind kind;
    double tau_min, tau_max, theory_min, theory_max, partial_min, partial_max, exact, fd, fd_all,
        weighted, cycle, running;
  };
  constexpr Row kTable[] = {
      {RendererKind::kStandard, -5.092, -0.328, -1.40, -0.57, -1.287, 0.405, 39.50, 4.75, 7.10,
       0.226, 0.559, -0.56},
      {RendererKind::kNullSpace, -10.227, -0.626, -0.74, -0.24, -0.198, 1.133, 59.80, 2.11, 3.90,
       0.085, -7.645, -0.05},
      {RendererKind::kSubspaceLinear, -13.885, -2.528, -1, -1, -1.429, -0.208, 0, 0, 0.40, 0.000,
       4.970, -4.97},
      {RendererKind::kSubspaceExact, -21.825, -2.664, -1, -1, -1, -1, 0, 0, 0, 0, 0, -0.22}};
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  const TrajectoryAnalysis a = analysis(*finger, 35, 50, 15);
  EXPECT_NEAR(a.peak_energy() * 1e6, 238.16, 0.05);  // mm^2
  EXPECT_NEAR(a.mean_actuated_jacobian(), 81.060, 5e-4);
  for (const Row& row : kTable) {
    SCOPED_TRACE(name(row.kind));
    const TrajectoryMetrics m = a.metrics(row.kind);
    EXPECT_NEAR(m.tau_min * 1e3, row.tau_min, 0.05);
    EXPECT_NEAR(m.tau_max * 1e3, row.tau_max, 0.05);
    EXPECT_NEAR(m.theory_min, row.theory_min, 0.006);
    EXPECT_NEAR(m.theory_max, row.theory_max, 0.006);
    EXPECT_NEAR(m.exact_partial_min, row.partial_min, 0.001);
    EXPECT_NEAR(m.exact_partial_max, row.partial_max, 0.001);
    EXPECT_NEAR(m.exact_nonpassive_pct, row.exact, 0.05);
    EXPECT_NEAR(m.fd_nonpassive_pct, row.fd, 0.05);
    EXPECT_NEAR(m.fd_all_nonpassive_pct, row.fd_all, 0.05);
    EXPECT_NEAR(m.fd_excluded_pct, 5.20, 0.05);
    EXPECT_NEAR(m.energy_weighted_pct, row.weighted, 0.05);
    EXPECT_NEAR(m.cycle_work_pct, row.cycle, 0.05);
    EXPECT_NEAR(m.cycle_work_reversed_pct, -row.cycle, 0.05);
    EXPECT_NEAR(m.running_energy_pct, row.running, 0.01);
    if (row.kind == RendererKind::kSubspaceExact) {
      EXPECT_LT(std::abs(m.cycle_work_pct), 1e-9);
    }
  }
}

TEST(TrajectoryB, OnlyTheLinearisedMethodIsActive) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  const TrajectoryAnalysis forth = analysis(*finger, 56, 70, 25);
  const TrajectoryAnalysis back = analysis(*finger, 56, 70, -25);
  const TrajectoryMetrics linear = forth.metrics(RendererKind::kSubspaceLinear);
  const TrajectoryMetrics reversed = back.metrics(RendererKind::kSubspaceLinear);
  EXPECT_GT(linear.fd_nonpassive_pct, 0.0);
  EXPECT_GT(std::abs(linear.cycle_work_pct), 1.0);
  EXPECT_LT(linear.cycle_work_pct * reversed.cycle_work_pct, 0.0) << "the sign follows the path's";
  const TrajectoryMetrics exact = forth.metrics(RendererKind::kSubspaceExact);
  EXPECT_EQ(exact.fd_nonpassive_pct, 0.0);
  EXPECT_LT(std::abs(exact.cycle_work_pct), 1e-9);
}

/// tests/report/STUDY.md#held-proxy-potential: with x held Eq. (6) is a potential; a zero-order
/// hold leaks exactly sum 1/2 dq^T Z_q dq.
TEST(ExactMethod, WorkBalancesPotentialOverMillionTicks) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  const double Z_q = 1500.0;
  const VecX x = (VecX(2) << 0.3, 0.4).finished();
  Renderer renderer(RendererKind::kSubspaceExact, *finger);
  std::mt19937_64 random(9);
  std::normal_distribution<double> step(0.0, 1.0);
  VecQ q = (VecQ(2) << 0.015, -0.3).finished();
  VecX x_probe = VecX::Zero(2), dx = VecX::Zero(2);
  MatXQ J = MatXQ::Identity(2, 2);
  const auto force = [&](bool changed) {
    Projection out;
    renderer.project(Probe{q, x_probe, J}, x, dx, VecA::Constant(1, Z_q), changed, out);
    return Z_q * (out.q_star[0] - q[0]);
  };
  double tau = force(true);
  const double V0 = 0.5 * tau * tau / Z_q;
  long double trapezoid = 0.0L, held = 0.0L, leak = 0.0L;
  double V = V0, peak = V0;
  for (int k = 0; k < 1000000; ++k) {
    const double before = q[0];
    q[0] = std::clamp(q[0] + 1e-5 * step(random), 0.0, 0.05);
    q[1] = std::clamp(q[1] + 1e-3 * step(random), -1.2, 0.7);
    const double next = force(false);
    const double dq = q[0] - before;
    trapezoid += 0.5L * (tau + next) * dq;
    held += static_cast<long double>(tau) * dq;
    leak += 0.5L * Z_q * dq * dq;
    tau = next;
    V = 0.5 * tau * tau / Z_q;
    peak = std::max(peak, V);
  }
  EXPECT_LT(std::abs(static_cast<double>(trapezoid + (V - V0))), 1e-12 * peak * 100);
  EXPECT_LT(std::abs(static_cast<double>(held - trapezoid - leak)), 1e-12 * peak * 100);
}

}  // namespace
}  // namespace haptic::core
