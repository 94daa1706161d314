/// core/METHOD.md#check-poses, core/METHOD.md#derivatives and core/METHOD.md#inverse-round-trip:
/// the finger's map, its derivatives and its inverse.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "tests/report/hard_cases/hard_case.hpp"
#include "tests/report/valid_region.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {
namespace {

using core::MatXQ;
using core::VecQ;
using core::VecX;

constexpr double kScale[2] = {0.02, 1.0};  ///< m, rad: core/METHOD.md#derivatives

void table_of_poses(const core::Kinematics& finger, Outcomes& out) {
  struct Row {
    double mcp, pip, l_mm, q_B_deg, J[4];
  };
  constexpr Row kTable[] = {{0, 0, 0.897, 30.489, {-45.332, -1.85, 93.498, 1.753}},
                            {30, 30, 15.864, -14.806, {-47.670, -1.424, 78.460, 0.484}},
                            {60, 70, 26.976, -54.730, {-81.598, -2.333, 141.512, 1.090}}};
  double f = 0.0, jacobian = 0.0, closure = 0.0;
  for (const Row& r : kTable) {
    const VecX wanted = (VecX(2) << r.mcp * kDegree, r.pip * kDegree).finished();
    VecQ q;
    VecX x;
    MatXQ J;
    if (finger.inverse(wanted, q) != core::InverseStatus::kExact ||
        finger.evaluate(q, x, J) != core::MapStatus::kOk) {
      f = HUGE_VAL;
      break;
    }
    f = std::max({f, std::abs(1e3 * q[0] - r.l_mm), std::abs(q[1] / kDegree - r.q_B_deg)});
    for (int i = 0; i < 4; ++i) jacobian = std::max(jacobian, std::abs(J(i / 2, i % 2) - r.J[i]));
  }
  std::mt19937_64 random(1);
  for (int i = 0; i < 2000; ++i) {
    const VecQ q = random_pose(random);
    closure = std::max(closure, core::finger_pose({}, q[0], q[1]).closure);
  }
  out.push_back(
      {"1", "f, J of core/METHOD.md#finger-linkage within 1e-3 as printed; loop closure < 1e-15 m",
       said("f within %.1e, J within %.1e; closure %.1e m", f, jacobian, closure),
       f <= 1e-3 && jacobian <= 1e-3 && closure < 1e-15});
}

/// Largest error of central differences relative to the largest entry, columns scaled by (0.02 m,
/// 1 rad): of J from f, and of dJ/dq_k from J.
struct Derivatives {
  double J{0.0}, H{0.0};
};

/// Central differences of f and of J along column k, both scaled; false where f has no value.
bool differences(const core::Kinematics& finger, const VecQ& q, int k, double step, VecX& of_f,
                 MatXQ& of_J) {
  VecQ up = q, down = q;
  up[k] += step * kScale[k];
  down[k] -= step * kScale[k];
  VecX up_x, down_x;
  MatXQ up_J, down_J;
  if (finger.evaluate(up, up_x, up_J) != core::MapStatus::kOk ||
      finger.evaluate(down, down_x, down_J) != core::MapStatus::kOk) {
    return false;
  }
  of_f = (up_x - down_x) / (2 * step);
  of_J = (up_J - down_J) * Eigen::Vector2d(kScale[0], kScale[1]).asDiagonal() / (2 * step);
  return true;
}

/// With `extrapolated` the differences' own error of order h^2 is taken off (Richardson).
Derivatives derivatives_at(const core::Kinematics& finger, const VecQ& q, bool extrapolated) {
  constexpr double kStep = 6e-6;
  VecX x, of_f, half_f;
  MatXQ J, J_k, of_J, half_J;
  if (finger.evaluate(q, x, J) != core::MapStatus::kOk) return {HUGE_VAL, HUGE_VAL};
  Derivatives error, largest;
  for (int k = 0; k < 2; ++k) {
    if (!differences(finger, q, k, kStep, of_f, of_J) ||
        !differences(finger, q, k, 0.5 * kStep, half_f, half_J) ||
        finger.second_order(q, k, J_k) != core::MapStatus::kOk) {
      return {HUGE_VAL, HUGE_VAL};
    }
    if (extrapolated) {
      of_f = (4 * half_f - of_f) / 3;
      of_J = (4 * half_J - of_J) / 3;
    }
    const VecX first = J.col(k) * kScale[k];
    const MatXQ second = J_k * Eigen::Vector2d(kScale[0], kScale[1]).asDiagonal() * kScale[k];
    error.J = std::max(error.J, (of_f - first).cwiseAbs().maxCoeff());
    error.H = std::max(error.H, (of_J - second).cwiseAbs().maxCoeff());
    largest.J = std::max(largest.J, first.cwiseAbs().maxCoeff());
    largest.H = std::max(largest.H, second.cwiseAbs().maxCoeff());
  }
  return {error.J / largest.J, error.H / largest.H};
}

void central_differences(const core::Kinematics& finger, Outcomes& out) {
  std::mt19937_64 random(2);
  Derivatives plain, worst;
  for (int i = 0; i < 2000; ++i) {
    const VecQ q = random_pose(random);
    const Derivatives at = derivatives_at(finger, q, false);
    plain = {std::max(plain.J, at.J), std::max(plain.H, at.H)};
    const Derivatives better = derivatives_at(finger, q, true);
    worst = {std::max(worst.J, better.J), std::max(worst.H, better.H)};
  }
  // The plain differences' largest error depends on which poses are drawn near the region's edge.
  out.push_back({"2",
                 "J < 2e-7, H < 5e-7 against central differences over 2000 poses, their own "
                 "error of order h^2 taken off",
                 said("J %.1e, H %.1e (with it %.1e, %.1e)", worst.J, worst.H, plain.J, plain.H),
                 worst.J < 2e-7 && worst.H < 5e-7});
}

void round_trip(const core::Kinematics& finger, Outcomes& out) {
  std::mt19937_64 random(3);
  double worst = 0.0;
  int differs = 0;
  VecX x, back;
  MatXQ J;
  VecQ q_before = VecQ::Zero(2);
  for (int i = 0; i < 100000; ++i) {
    const VecQ q = random_pose(random);
    VecQ fresh = VecQ::Zero(2);
    const bool ok = finger.evaluate(q, x, J) == core::MapStatus::kOk &&
                    finger.inverse(x, fresh) == core::InverseStatus::kExact &&
                    finger.inverse(x, q_before) == core::InverseStatus::kExact &&
                    finger.evaluate(fresh, back, J) == core::MapStatus::kOk;
    worst = ok ? std::max(worst, (back - x).cwiseAbs().maxCoeff()) : HUGE_VAL;
    differs += fresh == q_before ? 0 : 1;  // q_before came from the pose before
  }
  out.push_back({"3", "round trip of 1e5 poses < 1e-13 rad; the branch never depends on history",
                 said("%.1e rad; %d answers differ by what was asked before", worst, differs),
                 worst < 1e-13 && differs == 0});
}

}  // namespace

void kinematics_cases(Outcomes& out) {
  const auto finger = core::make_finger_exoskeleton({});
  table_of_poses(*finger, out);
  central_differences(*finger, out);
  round_trip(*finger, out);
}

}  // namespace haptic::report
