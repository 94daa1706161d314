/// core/METHOD.md#curved-wide-map and core/METHOD.md#hand-without-prior: where x does not determine
/// q.
#include <algorithm>
#include <cmath>
#include <random>

#include "haptic/core/error.hpp"
#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/projection/proxy_solver.hpp"
#include "haptic/core/projection/renderer.hpp"
#include "tests/core/projection/function_map.hpp"
#include "tests/report/hard_cases/hard_case.hpp"

namespace haptic::report {
namespace {

using core::MatXQ;
using core::VecA;
using core::VecQ;
using core::VecX;
using core::samples::FunctionMap;

const VecA kZ_q = (VecA(2) << 1.0, 50.0).finished();
const VecX kX = (VecX(2) << 0.5, 0.9).finished();
constexpr int kPlanes[3][2] = {{0, 1}, {0, 2}, {1, 2}};  // a0 a1, a0 n, a1 n

core::ProjectionModel with_prior(const FunctionMap& map, double mu) {
  core::ProjectionSettings settings;
  settings.prior = core::Prior{mu, VecQ::Ones(1)};
  settings.iteration = {400, 1e-15};
  return {map, settings};
}

/// Net work of tau_a around the circle in the plane of q_i and q_j, relative to the sum of its
/// parts' amounts. `q_star(q, first)`.
template <typename Anchor>
double loop_work(const int (&plane)[2], Anchor q_star) {
  constexpr int kPoints = 1501;
  double work = 0.0, amount = 0.0;
  VecQ last_q;
  VecA last_tau;
  for (int k = 0; k < kPoints; ++k) {
    const double phase = 2 * M_PI * k / (kPoints - 1);
    VecQ q = (VecQ(3) << .2, .1, .15).finished();
    q[plane[0]] += 0.15 * std::cos(phase);
    q[plane[1]] += 0.15 * std::sin(phase);
    const VecA tau = kZ_q.cwiseProduct((q_star(q, k == 0) - q).head(2));
    if (k > 0) {
      const double part = 0.5 * (tau + last_tau).dot((q - last_q).head(2));
      work += part;
      amount += std::abs(part);
    }
    last_q = q;
    last_tau = tau;
  }
  return std::abs(work) / amount;
}

double rendered(const core::ProjectionModel& model, const int (&plane)[2]) {
  core::Renderer renderer(core::RendererKind::kSubspaceExact, model);
  core::Projection out;
  return loop_work(plane, [&](const VecQ& q, bool first) {
    VecX x_probe;
    MatXQ J;
    static_cast<void>(model.kinematics().evaluate(q, x_probe, J));
    const VecX dx = kX - x_probe;
    renderer.project({q, x_probe, J}, kX, dx, kZ_q, first, out);
    return out.q_star;
  });
}

/// What core/METHOD.md#projection-algorithm forbids: a prior in the metric M drawn to the live q,
/// q_n included.
double with_live_q(const core::ProjectionModel& model, double mu, const VecQ& M,
                   const int (&plane)[2]) {
  core::ProxySolver solver(model);
  core::Projection out;
  return loop_work(plane, [&](const VecQ& q, bool first) {
    solver.set_prior((mu * M).cwiseSqrt(), q);
    const VecQ seed = first ? q : out.q_star;
    solver.solve(kX, seed, kZ_q, out);
    return out.q_star;
  });
}

void no_cycle_pumps(Outcomes& out) {
  const FunctionMap map = core::samples::wide_map();
  double held = 0.0, live_q_n = HUGE_VAL, live_q = HUGE_VAL;
  for (const double mu : {1e-3, 0.1}) {
    const core::ProjectionModel model = with_prior(map, mu);
    for (const auto& plane : kPlanes) {
      held = std::max(held, rendered(model, plane));
      live_q = std::min(live_q, with_live_q(model, mu, VecQ::Ones(3), plane));
    }
    const VecQ Z_q_and_M_n = (VecQ(3) << 1.0, 50.0, 1.0).finished();
    live_q_n = std::min(live_q_n, with_live_q(model, mu, Z_q_and_M_n, kPlanes[2]));
  }
  out.push_back({"9b",
                 "case B, circles in all planes, mu 1e-3 and 0.1: loop work/abs work < 1e-11; > "
                 "0.1 in plane (a1,n) with live q_n; > 0.1 in all with live q and M = I",
                 said("%.1e; %.2f; %.2f", held, live_q_n, live_q),
                 held < 1e-11 && live_q_n > 0.1 && live_q > 0.1});
}

bool refused(const core::ProjectionModel& model) {
  try {
    core::require_rank(model);
  } catch (const core::SceneError&) {
    return true;
  }
  return false;
}

/// The hand of core/METHOD.md#larger-devices over random poses: condition of J, and how far Eq. (8) goes
/// on 3 mm of noise.
struct Hand {
  double median_condition{0.0};
  double largest_dq{0.0};  ///< rad (m for the wrist's position)
};
Hand survey(const core::ProjectionModel& model, int poses) {
  const core::Kinematics& map = model.kinematics();
  std::mt19937_64 random(25);
  std::normal_distribution<double> noise(0.0, 0.003);
  core::Renderer renderer(core::RendererKind::kSubspaceLinear, model);
  core::LeastSquares solver(model.n_x(), model.layout());
  const VecA Z_q = VecA::Ones(model.layout().n_a());
  std::vector<double> conditions;
  Hand hand;
  for (int trial = 0; trial < poses; ++trial) {
    VecQ q(model.layout().n_q());
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const core::DofSpec& dof = map.dofs()[static_cast<std::size_t>(i)];
      q[i] = std::uniform_real_distribution<double>(dof.lower, dof.upper)(random);
    }
    VecX x_probe, x;
    MatXQ J;
    static_cast<void>(map.evaluate(q, x_probe, J));
    x = x_probe;
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += noise(random);
    const VecX dx = x - x_probe;
    solver.solve(J, dx, Z_q);
    conditions.push_back(solver.condition());
    core::Projection out;
    renderer.project({q, x_probe, J}, x, dx, Z_q, true, out);
    hand.largest_dq = std::max(hand.largest_dq, (out.q_star - q).cwiseAbs().maxCoeff());
  }
  const auto middle = conditions.begin() + poses / 2;
  std::nth_element(conditions.begin(), middle, conditions.end());
  hand.median_condition = *middle;
  return hand;
}

void hand_known_by_points(Outcomes& out) {
  constexpr int kPoses = 300;
  const FunctionMap two = core::samples::hand(2);  // n = 14
  core::ProjectionSettings settings;
  VecQ M_n(12);  // weights of core/METHOD.md#larger-devices: 0.1 per m of the wrist, 5 mm per rad
                 // elsewhere
  M_n << VecQ::Constant(3, 400.0), VecQ::Ones(9);
  settings.prior = core::Prior{2.5e-5, M_n};
  const core::ProjectionModel calm(two, settings);
  const Hand without = survey(core::ProjectionModel(two), kPoses), with = survey(calm, kPoses);
  const FunctionMap three = core::samples::hand(3), four = core::samples::hand(4);
  const bool refuses = refused(core::ProjectionModel(two));
  const bool takes = !refused(calm) && !refused(core::ProjectionModel(four));
  out.push_back(
      {"25",
       "hand n = 14 known by points: refused without a prior, regularised with one (3 mm of "
       "noise: < 1 rad); where x determines q none is asked for",
       said("%s; %.2f rad with a prior, %.0f without; median cond %.0f, %.0f, %.0f with 2, 3, 4 "
            "fingers",
            refuses ? "refused" : "not refused", with.largest_dq, without.largest_dq,
            without.median_condition, survey(core::ProjectionModel(three), kPoses).median_condition,
            survey(core::ProjectionModel(four), kPoses).median_condition),
       refuses && takes && with.largest_dq < 1.0 && without.largest_dq > 5.0});
}

}  // namespace

void prior_cases(Outcomes& out) {
  no_cycle_pumps(out);
  hand_known_by_points(out);
}

}  // namespace haptic::report
