/// haptic-report work-precision: what a way to q* of Eq. (6) costs and how near it comes, on frames
/// that are hard (tests/report/STUDY.md#hard-frames): the product's ways, KDL's LMA, damped least
/// squares.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <kdl/chainiksolverpos_lma.hpp>

#include "haptic/core/rendering/proxy_solver.hpp"
#include "haptic/core/rendering/renderer.hpp"
#include "tests/bench/paired.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/hard_frames.hpp"
#include "tests/support/cpu_time.hpp"
#include "tests/support/kdl_chain.hpp"

namespace haptic::report {
namespace {

using core::MatXQ;
using core::VecA;
using core::VecQ;
using core::VecX;

constexpr double kSolved = 1e-6;  // rad or m above the least residual

/// q* for the proxy x, the device at q; every way starts from q.
using Way = std::function<VecQ(const VecQ& q, const VecX& x)>;
struct Method {
  std::string name{};
  int steps{0};  ///< at most; 0: its own rule
  Way way{};
};

/// A renderer as the tick calls it.
Way rendered(std::shared_ptr<const core::Kinematics> map, core::RendererKind kind) {
  const auto renderer = std::make_shared<core::Renderer>(kind, core::ProjectionModel(*map));
  return [=](const VecQ& q, const VecX& x) {
    VecX at, dx;
    MatXQ J;
    core::Projection out;
    if (map->evaluate(q, at, J) != core::MapStatus::kOk) return q;
    map->space().difference(x, at, dx);
    renderer->reset();
    renderer->project({q, at, J}, x, dx, VecA::Ones(map->layout().n_a()), true, out);
    return out.q_star;
  };
}

Way iterated(std::shared_ptr<const core::Kinematics> map, int steps) {
  core::ProjectionSettings settings;
  settings.iteration.max_steps = steps;
  const auto solver = std::make_shared<core::ProxySolver>(core::ProjectionModel(*map, settings));
  return [=](const VecQ& q, const VecX& x) {
    core::Projection out;
    solver->solve(x, q, VecA::Ones(map->layout().n_a()), out);
    return out.q_star;
  };
}

/// C. W. Wampler's damped least squares (IEEE Trans. SMC 16(1):93-101, 1986), columns scaled by the
/// box, in which each step ends; damping 3 % of the root mean square singular value.
Way damped(std::shared_ptr<const core::Kinematics> map, int steps) {
  constexpr double kDamping = 0.03;
  return [=](VecQ q, const VecX& x) {
    VecX at, dx;
    MatXQ J;
    for (int n = 0; n < steps && map->evaluate(q, at, J) == core::MapStatus::kOk; ++n) {
      map->space().difference(x, at, dx);
      for (Eigen::Index k = 0; k < J.cols(); ++k) {
        const core::DofSpec& dof = map->dofs()[static_cast<std::size_t>(k)];
        J.col(k) *= dof.upper - dof.lower;
      }
      MatXQ normal = J.transpose() * J;
      normal.diagonal().array() +=
          kDamping * kDamping * normal.trace() / static_cast<double>(normal.rows());
      const VecQ step = normal.llt().solve(VecQ(J.transpose() * dx));
      for (Eigen::Index k = 0; k < q.size(); ++k) {
        const core::DofSpec& dof = map->dofs()[static_cast<std::size_t>(k)];
        q[k] = std::clamp(q[k] + step[k] * (dof.upper - dof.lower), dof.lower, dof.upper);
      }
    }
    return q;
  };
}

/// KDL's Levenberg-Marquardt on the tip's position. It knows no box: its answer is moved into it.
Way kdl_lma(const core::SerialChainParameters& parameters, int steps) {
  struct Lma {
    KDL::Chain chain;
    KDL::ChainIkSolverPos_LMA solver;
    Lma(const core::SerialChainParameters& p, int most)
        : chain(test::kdl(p)),
          solver(chain, (Eigen::Matrix<double, 6, 1>() << 1, 1, 1, 0, 0, 0).finished(), 1e-14,
                 most) {}
  };
  const auto lma = std::make_shared<Lma>(parameters, steps);
  return [lma](const VecQ& q, const VecX& x) {
    KDL::JntArray from(static_cast<unsigned>(q.size())), to(static_cast<unsigned>(q.size()));
    from.data = q;
    lma->solver.CartToJnt(from, KDL::Frame(KDL::Vector(x[0], x[1], x[2])), to);
    return VecQ(to.data);
  };
}

std::vector<Method> methods(const HardFrames& frames) {
  const auto& map = frames.kinematics;
  std::vector<Method> all{{"eq8", 0, rendered(map, core::RendererKind::kSubspaceLinear)},
                          {"eq6", 0, rendered(map, core::RendererKind::kSubspaceExact)}};
  for (const int steps : {1, 2, 3, 5, 10, 30, 100}) {
    all.push_back({"iteration", steps, iterated(map, steps)});
  }
  for (const int steps : {1, 3, 10, 30, 100}) {
    all.push_back({"damped_least_squares", steps, damped(map, steps)});
    if (frames.map != "arm") continue;  // KDL has no closed loops
    all.push_back({"kdl_lma", steps, kdl_lma(hard_arm(), steps)});
  }
  return all;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return NAN;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void print(HardFrames frames, int blocks) {
  const std::vector<Method> all = methods(frames);
  const std::size_t n = frames.q.size();
  if (n == 0) return;
  std::vector<std::vector<double>> residual(all.size());
  std::vector<std::size_t> failed(all.size(), 0);
  double beaten = 0.0;
  for (std::size_t m = 0; m < all.size(); ++m) {
    for (std::size_t i = 0; i < n; ++i) {
      const VecQ q_star = all[m].way(frames.q[i], frames.x[i]);
      residual[m].push_back(residual_inside(*frames.kinematics, q_star, frames.x[i]));
      if (std::isnan(residual[m].back())) {  // no answer: the device's own pose stands
        ++failed[m];
        residual[m].back() = residual_inside(*frames.kinematics, frames.q[i], frames.x[i]);
      }
      const double found = residual[m].back();
      if (!(found < frames.least[i])) continue;
      beaten = std::max(beaten, frames.least[i] - found);
      frames.least[i] = found;
    }
  }
  std::fprintf(stderr,
               "work-precision: %s %s: a method is below the reference by at most %.2g %s\n",
               frames.map.c_str(), frames.what.c_str(), beaten, frames.unit.c_str());
  for (std::size_t m = 0; m < all.size(); ++m) {
    std::vector<double> excess;
    std::size_t solved = 0;
    for (std::size_t i = 0; i < n; ++i) {
      excess.push_back(residual[m][i] - frames.least[i]);
      solved += excess.back() <= kSolved ? 1 : 0;
    }
    const bench::Figure timed = bench::measure(
        all[m].name, "ns",
        [&] {
          const double start = test::cpu_ns();
          for (std::size_t i = 0; i < n; ++i) {
            static_cast<void>(all[m].way(frames.q[i], frames.x[i]));
          }
          return (test::cpu_ns() - start) / static_cast<double>(n);
        },
        0.0, blocks);
    const double share = 100.0 / static_cast<double>(n);
    row(frames.map, frames.what, all[m].name, all[m].steps, n, timed.value.median,
        timed.value.lower, timed.value.upper, quantile(excess, 0.5), quantile(excess, 0.95),
        quantile(excess, 1.0), frames.unit, share * static_cast<double>(solved),
        share * static_cast<double>(failed[m]));
  }
  std::fflush(stdout);
}

}  // namespace

void add_work_precision(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("work-precision", "ns and error of ways to q*, on frames that are hard");
  command->footer(
      "excess: residual ||x (-) f(q*)|| of the answer, moved into the box, above the least that is "
      "known (0 where x is an image; else a grid of the box, descended, or what a method found). "
      "solved: excess at most 1e-6 rad or m. failed: f has no value at the answer, or a slider is "
      "beyond its end; the device's own pose counts instead. eq8, eq6: the renderers as the tick "
      "calls them, cold. "
      "iteration: that behind eq6, which ends after 10 steps, with fewer and more. "
      "damped_least_squares: Wampler's. kdl_lma: "
      "KDL's, on the arm alone, for KDL has no closed loops.");
  auto frames = std::make_shared<int>(200);
  auto blocks = std::make_shared<int>(24);
  command->add_option("--frames", *frames, "per kind and map (200)")->check(CLI::Range(1, 100000));
  command->add_option("--blocks", *blocks, "of timing (24)")->check(CLI::Range(1, 1000));
  command->callback([frames, blocks] {
    row("map", "frames", "method", "steps", "count", "ns", "ns_lower", "ns_upper", "excess_median",
        "excess_p95", "excess_max", "unit", "solved_pct", "failed_pct");
    for (const auto& make : {&hard_frames_of_finger, &hard_frames_of_arm}) {
      for (HardFrames& one : make(*frames)) print(std::move(one), *blocks);
    }
  });
}

}  // namespace haptic::report
