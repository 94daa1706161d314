/// core/METHOD.md#near-the-fold and core/METHOD.md#unreachable-proxies: near a fold of the map, and
/// beyond its reach.
#include <algorithm>
#include <cmath>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/report/hard_cases/hard_case.hpp"
#include "tests/report/hard_cases/linear_device.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {
namespace {

using core::VecA;
using core::VecQ;
using core::VecX;

void near_the_fold(const core::Kinematics& finger, Outcomes& out) {
  const VecX x = VecX::Zero(2);
  const auto dq_mm = [&](core::RendererKind kind, double q_B_deg) {
    const VecQ q = (VecQ(2) << 0.5e-3, q_B_deg * kDegree).finished();
    return 1e3 * force_of(kind, finger, q, x, VecA::Ones(1))[0];
  };
  const double far = dq_mm(core::RendererKind::kSubspaceLinear, 40.0);
  const double near = dq_mm(core::RendererKind::kSubspaceLinear, 49.7);
  double lowest = HUGE_VAL, highest = -HUGE_VAL;
  for (int i = 0; i <= 97; ++i) {
    const double exact = dq_mm(core::RendererKind::kSubspaceExact, 40.0 + 0.1 * i);
    lowest = std::min(lowest, exact);
    highest = std::max(highest, exact);
  }
  out.push_back({"15",
                 "l = 0.5 mm, x = 0, q_B 40..49.7 deg: (8) dq_a -1.30 .. -279 mm, (6) +0.397 "
                 "mm at all",
                 said("(8) %.2f .. %.0f mm; (6) %+.3f .. %+.3f mm", far, near, lowest, highest),
                 std::abs(far + 1.30) < 0.01 && std::abs(near + 279) < 1 &&
                     std::abs(lowest - 0.397) < 1e-3 && std::abs(highest - 0.397) < 1e-3});
}

struct Found {
  double residual{HUGE_VAL};  ///< rad
  double l{0.0}, t{0.0};
};

double residual_at(const core::FingerDimensions& d, const VecX& x, double l, double t) {
  if (l < d.l_x_lower || l > d.l_x_upper || t < d.q_B_lower || t > d.q_B_upper) return HUGE_VAL;
  const core::FingerPose pose = core::finger_pose(d, l, t);
  if (pose.status != core::MapStatus::kOk || pose.c1 < d.slider1_lower ||
      pose.c1 > d.slider1_upper || pose.c2 < d.slider2_lower || pose.c2 > d.slider2_upper) {
    return HUGE_VAL;
  }
  return std::hypot(pose.q_o1 - x[0], pose.q_o2 - x[1]);
}

/// The nearest pose in reach by exhaustion: a grid over the box, refined around its best.
Found exhaustive(const core::FingerDimensions& d, const VecX& x) {
  Found best;
  double l_from = d.l_x_lower, l_to = d.l_x_upper, t_from = d.q_B_lower, t_to = d.q_B_upper;
  for (int level = 0; level < 8; ++level) {
    constexpr int kSteps = 200;
    for (int i = 0; i <= kSteps; ++i) {
      for (int k = 0; k <= kSteps; ++k) {
        const double l = l_from + (l_to - l_from) * i / kSteps;
        const double t = t_from + (t_to - t_from) * k / kSteps;
        const double residual = residual_at(d, x, l, t);
        if (residual < best.residual) best = {residual, l, t};
      }
    }
    const double half_l = 3 * (l_to - l_from) / kSteps, half_t = 3 * (t_to - t_from) / kSteps;
    l_from = std::max(d.l_x_lower, best.l - half_l);
    l_to = std::min(d.l_x_upper, best.l + half_l);
    t_from = std::max(d.q_B_lower, best.t - half_t);
    t_to = std::min(d.q_B_upper, best.t + half_t);
  }
  return best;
}

void out_of_reach(const core::Kinematics& finger, Outcomes& out) {
  struct Row {
    double mcp, pip, residual_deg;  // 0: no published figure
  };
  constexpr Row kRows[] = {{-0.5, 0.3, 4.860},  {-0.7, 0.35, 16.051}, {-1.0, 0.3, 33.242},
                           {-0.5, -0.5, 38.66}, {2.2, 1.0, 0},        {0.3, 2.9, 0}};
  const core::FingerDimensions d;
  bool told = true, close = true, below_seed = true;
  double gap_deg = -HUGE_VAL;
  std::string got = "residuals";
  for (const Row& r : kRows) {
    const VecX x = (VecX(2) << r.mcp, r.pip).finished();
    VecQ q = (VecQ(2) << 4e-3, 0.4).finished();
    const double seed = residual_at(d, x, q[0], q[1]);
    told = told && finger.inverse(x, q) == core::InverseStatus::kUnreachable && q.allFinite();
    const core::FingerPose pose = core::finger_pose(d, q[0], q[1]);
    const double residual = std::hypot(pose.q_o1 - x[0], pose.q_o2 - x[1]);
    below_seed = below_seed && residual <= seed;
    gap_deg = std::max(gap_deg, (residual - exhaustive(d, x).residual) / kDegree);
    close = close && (r.residual_deg == 0 || std::abs(residual / kDegree - r.residual_deg) < 0.005);
    got += said(" %.2f", residual / kDegree);
  }
  out.push_back({"16",
                 "six unreachable x: finite, told, cost never above the seed's; residuals "
                 "4.86 16.05 33.24 38.66 deg; gap to the global minimum",
                 got + said(" deg; %s, %s; gap to exhaustion %.1e deg", told ? "told" : "not told",
                            below_seed ? "below the seed" : "above the seed", gap_deg),
                 told && close && below_seed && gap_deg < 1e-4});
}

}  // namespace

void reach_cases(Outcomes& out) {
  const auto finger = core::make_finger_exoskeleton({});
  near_the_fold(*finger, out);
  out_of_reach(*finger, out);
}

}  // namespace haptic::report
