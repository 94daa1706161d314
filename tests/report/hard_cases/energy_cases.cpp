/// core/METHOD.md#proxy-step, core/METHOD.md#late-client and
/// core/METHOD.md#lost-and-repeated-samples: what a change of the proxy brings into the loop, and
/// the tank.
#include <algorithm>
#include <cmath>

#include "tests/report/hard_cases/hard_case.hpp"
#include "tests/report/hard_cases/loop.hpp"
#include "tests/report/values.hpp"
#include "tests/support/loop/wall_run.hpp"

namespace haptic::report {
namespace {

using core::VecQ;
using core::VecX;
using test::wall_tank;
using test::WallFigures;
using test::WallRun;

constexpr double kZ = 1500.0;    // N/m
constexpr double kLimit = 20.0;  // N: hard_cases/loop.hpp

/// Of the saturated spring, core/METHOD.md#actuator-limits: quadratic up to the force limit, linear
/// beyond.
double stored(double stretch) {
  const double d = std::abs(stretch);
  return kZ * d <= kLimit ? 0.5 * kZ * d * d : kLimit * (d - 0.5 * kLimit / kZ);
}

/// One frame that moves the proxy by 1 rad (the norm over both joints), device held.
struct Step {
  core::TickRecord before{}, after{};
  double wanted{0.0};  ///< dV_j by the closed form of q* and the spring's potential, J
};
Step step_with(double tank_initial) {
  core::PassivitySettings passivity;
  passivity.tank.enabled = true;
  passivity.tank.initial = tank_initial;
  passivity.tank.capacity = 10.0;
  Loop loop(core::RendererKind::kSubspaceExact, kZ, passivity);
  const auto finger = core::make_finger_exoskeleton({});
  const VecX near = (VecX(2) << 0.9, 0.9).finished();
  const VecX far = near - VecX::Constant(2, std::sqrt(0.5));
  VecQ q, q_near, q_far;
  static_cast<void>(finger->inverse((VecX(2) << 0.95, 0.95).finished(), q));
  static_cast<void>(finger->inverse(near, q_near));
  static_cast<void>(finger->inverse(far, q_far));
  Step step;
  step.before = loop.engage(q, near);
  step.after = loop.tick(q, far);
  step.wanted = stored(q_far[0] - q[0]) - stored(q_near[0] - q[0]);
  return step;
}

void proxy_step(Outcomes& out) {
  const Step rich = step_with(5.0), poor = step_with(0.0);
  const double error = std::abs(rich.after.effort.passivity.injected - rich.wanted) / rich.wanted;
  const double budget = std::max(poor.before.effort.passivity.tank, 0.0);
  const double over = poor.after.effort.passivity.injected - budget;
  const double force =
      std::max(std::abs(rich.after.effort.tau_a[0]), std::abs(poor.after.effort.tau_a[0]));
  out.push_back(
      {"18",
       "proxy step of 1 rad in one frame: V jumps by dV_j to 1e-12; the tank caps it; "
       "|tau| <= tau_max",
       said("%.1f mJ, off by %.1e of it; with an empty tank %.1e mJ more than it held, %s; "
            "%.1f of %.0f N",
            1e3 * rich.wanted, error, 1e3 * over,
            poor.after.effort.passivity.throttled ? "throttled" : "not throttled", force, kLimit),
       rich.wanted > 0.0 && error < 1e-12 && over <= 1e-12 &&
           poor.after.effort.passivity.throttled && force <= kLimit});
}

WallRun in_and_out(core::ProxyMode mode, double initial) {
  WallRun run = test::wall_run(mode);  // K = 1500 N/m, 60 Hz, 20 ms, jitter 30 %
  run.passivity = wall_tank(initial);
  return run;
}

void late_and_jittered(Outcomes& out) {
  double over = -HUGE_VAL, q = 0.0;
  for (const core::ProxyMode mode : {core::ProxyMode::kHeld, core::ProxyMode::kPlanes}) {
    for (const double initial : {0.0, 2e-3}) {
      const WallFigures result = test::run(in_and_out(mode, initial));
      over = std::max(over, result.most_net - initial);
      q = std::max(q, result.largest_q);
    }
  }
  WallRun plain = in_and_out(core::ProxyMode::kPlanes, 0.0);
  plain.passivity = {};
  const double planes = test::run(plain).most_net;
  plain.client.mode = core::ProxyMode::kHeld;
  const double held = test::run(plain).most_net;
  out.push_back({"22",
                 "in/out wall, K = 1500, 20 ms, jitter 30 %, held and planes: work net of damping "
                 "<= tank + 1e-9 J, q bounded; planes without the tank < 2 mJ",
                 said("%.1e J above the tank, |q| <= %.0f mm; planes alone %.2f mJ (a held proxy "
                      "alone %.0f mJ)",
                      over, 1e3 * q, 1e3 * planes, 1e3 * held),
                 over <= 1e-9 && q < 0.05 && planes < 2e-3 && held > 1e-3});
}

void lost_and_disordered(Outcomes& out) {
  double over = -HUGE_VAL;
  int runs = 0;
  for (const core::ProxyMode mode : {core::ProxyMode::kHeld, core::ProxyMode::kPlanes}) {
    for (const double initial : {0.0, 2e-3}) {
      for (const double rate : {30.0, 60.0, 200.0}) {
        WallRun run = in_and_out(mode, initial);
        run.client.rate_hz = rate;
        run.client.lost = 0.5;
        run.client.disorder = true;
        over = std::max(over, test::run(run).most_net - initial);
        ++runs;
      }
    }
  }
  out.push_back({"23",
                 "half of the frames dropped, the rest twice and out of order: no energy above "
                 "the tank",
                 said("%.1e J above the tank in %d runs", over, runs), over <= 1e-9});
}

}  // namespace

void energy_cases(Outcomes& out) {
  proxy_step(out);
  late_and_jittered(out);
  lost_and_disordered(out);
}

}  // namespace haptic::report
