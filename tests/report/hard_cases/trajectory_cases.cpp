/// core/METHOD.md#trajectory-a, core/METHOD.md#trajectory-b, core/METHOD.md#held-proxy-potential
/// and core/METHOD.md#frozen-actuator: passivity along trajectories.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "haptic/core/analysis/trajectory_metrics.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/projection/renderer.hpp"
#include "tests/report/hard_cases/hard_case.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {
namespace {

using core::VecA;
using core::VecQ;
using core::VecX;

std::array<core::TrajectoryMetrics, 4> metrics(const core::Kinematics& finger, const Pair& A,
                                               double psi) {
  core::GraspCycle grasp;
  grasp.A1 = A.first * kDegree;
  grasp.A2 = A.second * kDegree;
  grasp.psi = psi * kDegree;
  const core::TrajectoryAnalysis analysis(finger, core::sampled(finger, grasp), VecX::Zero(2), 1.0);
  std::array<core::TrajectoryMetrics, 4> all;
  for (std::size_t i = 0; i < 4; ++i) all[i] = analysis.metrics(kMethods[i]);
  return all;
}

void trajectory_a(const core::Kinematics& finger, Outcomes& out) {
  constexpr double kFd[] = {4.7, 2.1, 0.0, 0.0}, kWork[] = {0.56, -7.65, 4.97, 0.00};
  const auto m = metrics(finger, {35, 50}, 15);
  bool passed = true;
  for (std::size_t i = 0; i < 4; ++i) {
    passed = passed && std::abs(m[i].fd_nonpassive_pct - kFd[i]) <= 0.3 &&
             std::abs(m[i].cycle_work_pct - kWork[i]) <= 0.05;
  }
  out.push_back(
      {"7",
       "trajectory A: FD non-passive 4.7/2.1/0/0 % +-0.3; cycle work "
       "+0.56/-7.65/+4.97/0.00 %",
       said("%.2f/%.2f/%.2f/%.2f %%; %+.2f/%+.2f/%+.2f/%.0e %%", m[0].fd_nonpassive_pct,
            m[1].fd_nonpassive_pct, m[2].fd_nonpassive_pct, m[3].fd_nonpassive_pct,
            m[0].cycle_work_pct, m[1].cycle_work_pct, m[2].cycle_work_pct, m[3].cycle_work_pct),
       passed});
}

void trajectory_b(const core::Kinematics& finger, Outcomes& out) {
  const auto forth = metrics(finger, {56, 70}, 25), back = metrics(finger, {56, 70}, -25);
  const core::TrajectoryMetrics &linear = forth[2], &exact = forth[3];
  out.push_back({"8",
                 "trajectory B: (8) has non-passive FD samples and cycle work of several % "
                 "whose sign flips with the direction; (6) 0 %",
                 said("(8) %.1f %%, %+.2f and %+.2f %%; (6) %.1f %%, %.0e %%",
                      linear.fd_nonpassive_pct, linear.cycle_work_pct, back[2].cycle_work_pct,
                      exact.fd_nonpassive_pct, exact.cycle_work_pct),
                 linear.fd_nonpassive_pct > 0 && std::abs(linear.cycle_work_pct) > 2 &&
                     linear.cycle_work_pct * back[2].cycle_work_pct < 0 &&
                     exact.fd_nonpassive_pct == 0 && std::abs(exact.cycle_work_pct) < 1e-9});
}

/// x held, a random walk of q over 1e6 ticks: trapezoidal work + V is conserved; with the force
/// held over each tick it differs by exactly sum 1/2 dq^T Z dq.
void random_walk(const core::Kinematics& finger, Outcomes& out) {
  constexpr double kZ = 1500.0;
  const VecX x = (VecX(2) << 0.3, 0.4).finished();
  core::Renderer renderer(core::RendererKind::kSubspaceExact, finger);
  std::mt19937_64 random(9);
  std::normal_distribution<double> step;
  VecQ q = (VecQ(2) << 0.015, -0.3).finished();
  VecX x_probe, dx(2);
  core::MatXQ J;
  core::Projection projection;
  bool first = true;
  const auto force = [&] {
    if (finger.evaluate(q, x_probe, J) != core::MapStatus::kOk) return std::nan("");
    finger.space().difference(x, x_probe, dx);
    renderer.project(core::Probe{q, x_probe, J}, x, dx, VecA::Constant(1, kZ), first, projection);
    first = false;
    return kZ * (projection.q_star[0] - q[0]);
  };
  double tau = force();
  const double V0 = 0.5 * tau * tau / kZ;
  double V = V0, peak = V0;
  // Sums of 1e6 terms: in long double, so that what is judged is the force and not the adding up.
  long double trapezoid = 0, held = 0, leak = 0;
  for (int k = 0; k < 1000000; ++k) {
    const double before = q[0];
    // Held within a part of the region in which the map exists everywhere.
    q[0] = std::clamp(q[0] + 1e-5 * step(random), 0.012, 0.020);
    q[1] = std::clamp(q[1] + 1e-3 * step(random), -0.45, -0.05);
    const double next = force();
    const long double dq = static_cast<long double>(q[0]) - before;
    trapezoid += 0.5L * (static_cast<long double>(tau) + next) * dq;
    held += tau * dq;
    leak += 0.5L * kZ * dq * dq;
    tau = next;
    V = 0.5 * tau * tau / kZ;
    peak = std::max(peak, V);
  }
  const double conserved = std::abs(static_cast<double>(trapezoid + (V - V0))) / peak;
  const double exactly = std::abs(static_cast<double>(held - trapezoid - leak)) / peak;
  out.push_back({"9",
                 "(6), x held, 1e6 ticks: work + V conserved < 1e-12 of peak V; held force "
                 "differs by sum 1/2 dq^T Z dq",
                 said("%.1e; %.1e", conserved, exactly), conserved < 1e-12 && exactly < 1e-12});
}

void frozen_actuator(Outcomes& out) {
  const std::vector<double> still(100, 0.02);
  std::vector<double> tau;
  for (int i = 0; i < 100; ++i) tau.push_back(std::sin(0.3 * i));
  const core::FiniteDifferences fd = core::finite_differences(still, tau);
  const bool finite = std::isfinite(fd.nonpassive_pct) && std::isfinite(fd.energy_weighted_pct);
  out.push_back(
      {"19", "q_a frozen: no division, the FD metric skips",
       said("%d of %d steps kept, %s", fd.kept, fd.steps, finite ? "finite" : "not finite"),
       fd.kept == 0 && fd.steps == 99 && finite});
}

}  // namespace

void trajectory_cases(Outcomes& out) {
  const auto finger = core::make_finger_exoskeleton({});
  trajectory_a(*finger, out);
  trajectory_b(*finger, out);
  random_walk(*finger, out);
  frozen_actuator(out);
}

}  // namespace haptic::report
