// The paper's Fig. 4 with the metrics of METHOD 2.3: cases 7, 8 and 9 of METHOD 6, all unguarded.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/projection/renderer.hpp"

namespace haptic::core {
namespace {

constexpr double kDegree = 0.017453292519943295;
constexpr RendererKind kAll[] = {RendererKind::kStandard, RendererKind::kNullSpace,
                                 RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact};

struct Metrics {
  double tau_min{0}, tau_max{0}, exact_partial_min{0}, exact_partial_max{0}, exact_pct{0};
  double fd_pct{0}, fd_excluded_pct{0}, fd_all_pct{0}, energy_weighted_pct{0};
  double cycle_pct{0}, reversed_pct{0};
};

class Trajectory {
 public:
  Trajectory(double A1, double A2, double psi_deg) {
    constexpr int kSamples = 4000;
    double mean = 0.0;
    for (int i = 0; i < kSamples; ++i) {
      const double phase = 2.0 * std::numbers::pi * 0.5 * i / 500.0;
      VecX x(2);
      x << (4.0 + A1 * (1.0 - std::cos(phase)) / 2.0) * kDegree,
          (4.0 + A2 * (1.0 - std::cos(phase - psi_deg * kDegree)) / 2.0) * kDegree;
      VecQ q;
      EXPECT_EQ(finger_->inverse(x, q), InverseStatus::kExact);
      q_.push_back(q);
      VecX x_probe;
      MatXQ J;
      EXPECT_EQ(finger_->evaluate(q, x_probe, J), MapStatus::kOk);
      mean += J.col(0).norm() / kSamples;
    }
    z_x_ = 1.0 / (mean * mean);
    VecQ q_star;
    EXPECT_EQ(finger_->inverse(VecX::Zero(2), q_star), InverseStatus::kExact);
    for (const VecQ& q : q_) {
      peak_ = std::max(peak_, 0.5 * std::pow(1e3 * (q_star[0] - q[0]), 2));
    }
  }

  [[nodiscard]] double peak() const { return peak_; }

  /// Force in mm (Z_q = 1) at sample q with x = 0, the renderer's Z_x rescaled to the trajectory's.
  double tau(RendererKind kind, const VecQ& q) {
    VecX x_probe;
    MatXQ J;
    EXPECT_EQ(finger_->evaluate(q, x_probe, J), MapStatus::kOk);
    const VecX x = VecX::Zero(2), dx = -x_probe;
    Renderer renderer(kind, *finger_);
    Projection out;
    renderer.project(Probe{q, x_probe, J}, x, dx, VecA::Ones(1), true, out);
    const double scale = kind == RendererKind::kStandard || kind == RendererKind::kNullSpace
                             ? z_x_ * std::pow(finger_->mean_actuated_jacobian(), 2)
                             : 1.0;
    return 1e3 * scale * (out.q_star[0] - q[0]);
  }

  Metrics measure(RendererKind kind) {
    std::vector<double> tau_mm, l_mm;
    Metrics m;
    int positive = 0;
    for (const VecQ& q : q_) {
      tau_mm.push_back(tau(kind, q));
      l_mm.push_back(1e3 * q[0]);
      // d tau_a/dq_a with q_n and x fixed, by central differences of the force itself.
      const double h = 1e-7;
      VecQ up = q, down = q;
      up[0] += h;
      down[0] -= h;
      const double partial = 1e-3 * (tau(kind, up) - tau(kind, down)) / (2.0 * h);
      m.exact_partial_min = std::min(m.exact_partial_min, partial);
      m.exact_partial_max = tau_mm.size() == 1 ? partial : std::max(m.exact_partial_max, partial);
      positive += partial > 0.0;
    }
    m.exact_pct = 100.0 * positive / 4000.0;
    m.tau_min = *std::min_element(tau_mm.begin(), tau_mm.end());
    m.tau_max = *std::max_element(tau_mm.begin(), tau_mm.end());
    double rms = 0.0;
    for (int i = 0; i < 3999; ++i) rms += std::pow(l_mm[i + 1] - l_mm[i], 2) / 3999.0;
    rms = std::sqrt(rms);
    int kept = 0, kept_bad = 0, all = 0, all_bad = 0;
    double up = 0.0, total = 0.0;
    for (int i = 0; i < 3999; ++i) {
      const double dq = l_mm[i + 1] - l_mm[i], dtau = tau_mm[i + 1] - tau_mm[i];
      up += std::max(0.0, dtau * dq);
      total += std::abs(dtau * dq);
      if (dq == 0.0) continue;
      ++all;
      all_bad += dtau / dq > 0.0;
      if (std::abs(dq) > 0.1 * rms) {
        ++kept;
        kept_bad += dtau / dq > 0.0;
      }
    }
    m.fd_pct = 100.0 * kept_bad / kept;
    m.fd_excluded_pct = 100.0 * (1.0 - kept / 3999.0);
    m.fd_all_pct = 100.0 * all_bad / all;
    m.energy_weighted_pct = 100.0 * up / total;
    for (int i = 0; i < 1000; ++i) {  // samples N..2N, 2N = N
      const int a = 1000 + i, b = 1000 + (i + 1) % 1000;
      m.cycle_pct += 0.5 * (tau_mm[a] + tau_mm[b]) * (l_mm[b] - l_mm[a]);
      m.reversed_pct += 0.5 * (tau_mm[a] + tau_mm[b]) * (l_mm[a] - l_mm[b]);
    }
    m.cycle_pct *= 100.0 / peak_;
    m.reversed_pct *= 100.0 / peak_;
    return m;
  }

 private:
  std::unique_ptr<Kinematics> finger_ = make_finger_exoskeleton({});
  std::vector<VecQ> q_{};
  double z_x_{0.0};
  double peak_{0.0};
};

/// METHOD 2.3, the table of trajectory A; every entry within 0.05.
TEST(TrajectoryA, ReproducesTheTable) {
  struct Row {
    RendererKind kind;
    double tau_min, tau_max, partial_min, partial_max, exact, fd, fd_all, weighted, cycle;
  };
  constexpr Row kTable[] = {
      {RendererKind::kStandard, -5.092, -0.328, -1.287, 0.405, 39.50, 4.75, 7.10, 0.226, 0.559},
      {RendererKind::kNullSpace, -10.227, -0.626, -0.198, 1.133, 59.80, 2.11, 3.90, 0.085, -7.645},
      {RendererKind::kSubspaceLinear, -13.885, -2.528, -1.429, -0.208, 0, 0, 0.40, 0.000, 4.970},
      {RendererKind::kSubspaceExact, -21.825, -2.664, -1, -1, 0, 0, 0, 0, 0}};
  Trajectory a(35, 50, 15);
  EXPECT_NEAR(a.peak(), 238.16, 0.05);
  for (const Row& row : kTable) {
    SCOPED_TRACE(name(row.kind));
    const Metrics m = a.measure(row.kind);
    EXPECT_NEAR(m.tau_min, row.tau_min, 0.05);
    EXPECT_NEAR(m.tau_max, row.tau_max, 0.05);
    EXPECT_NEAR(m.exact_partial_min, row.partial_min, 0.05);
    EXPECT_NEAR(m.exact_partial_max, row.partial_max, 0.05);
    EXPECT_NEAR(m.exact_pct, row.exact, 0.05);
    EXPECT_NEAR(m.fd_pct, row.fd, 0.05);
    EXPECT_NEAR(m.fd_all_pct, row.fd_all, 0.05);
    EXPECT_NEAR(m.fd_excluded_pct, 5.20, 0.05);
    EXPECT_NEAR(m.energy_weighted_pct, row.weighted, 0.05);
    EXPECT_NEAR(m.cycle_pct, row.cycle, 0.05);
    EXPECT_NEAR(m.reversed_pct, -row.cycle, 0.05);
    if (row.kind == RendererKind::kSubspaceExact) {
      EXPECT_LT(std::abs(m.cycle_pct), 1e-9);
    }
  }
}

TEST(TrajectoryB, TheLinearisedMethodIsActiveAndTheExactIsNot) {
  Trajectory forth(56, 70, 25), back(56, 70, -25);
  const Metrics linear = forth.measure(RendererKind::kSubspaceLinear);
  const Metrics reversed = back.measure(RendererKind::kSubspaceLinear);
  EXPECT_GT(linear.fd_pct, 0.0);
  EXPECT_GT(std::abs(linear.cycle_pct), 1.0);
  EXPECT_LT(linear.cycle_pct * reversed.cycle_pct, 0.0) << "the sign follows the direction";
  const Metrics exact = forth.measure(RendererKind::kSubspaceExact);
  EXPECT_EQ(exact.fd_pct, 0.0);
  EXPECT_LT(std::abs(exact.cycle_pct), 1e-9);
}

/// METHOD 6, case 9: with x held Eq. (6) is a potential; a zero-order hold leaks exactly
/// sum 1/2 dq^T Z_q dq.
TEST(ExactMethod, WorkAndPotentialBalanceOverAMillionTicks) {
  const auto finger = make_finger_exoskeleton({});
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
