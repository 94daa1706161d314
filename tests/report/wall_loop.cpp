#include "tests/report/wall_loop.hpp"

#include <algorithm>
#include <cmath>

#include "haptic/core/model/linear.hpp"
#include "hw/motion/minimum_jerk.hpp"
#include "tests/support/loop/hand_mass.hpp"
#include "tests/support/loop/pipeline_loop.hpp"

namespace haptic::report {
namespace {

using core::VecA;
using core::VecQ;

constexpr double kEngage_s = 0.6;      // ten samples at 30 Hz, 100 ms late, and some
constexpr double kBegin_s = 0.9;       // the gain's ramp is over
constexpr double kCentre = -0.002;     // m, of the hand's cycle
constexpr double kPressDepth = 0.020;  // m: where the pressing hand aims
constexpr int kSubsteps = 10;

core::PipelineConfig pipeline_for(const WallLoop& what) {
  core::LinearMap map;
  map.dofs = {{"l", core::Unit::kMetre, true, -0.2, 0.2}};
  map.coordinates = {{"x", core::Unit::kMetre, core::CoordinateKind::kLinear}};
  map.A = core::MatXQ::Identity(1, 1);
  map.x_0 = core::VecX::Zero(1);
  core::PipelineConfig c;
  c.kinematics = core::make_linear(map);
  c.device.q_lower = VecQ::Constant(1, -1.0);
  c.device.q_upper = VecQ::Constant(1, 1.0);
  c.device.max_effort = VecA::Constant(1, 100.0);
  c.scene.stiffness = VecA::Constant(1, what.stiffness);
  c.scene.damping = VecA::Zero(1);
  c.scene.force_limit = VecA::Constant(1, 60.0);
  c.scene.slew_limit = VecA::Constant(1, 1e7);
  c.scene.engage_window = VecA::Constant(1, 60.0);
  // The ladder of WIRE 4 has its own tests; here a slow client is still a client.
  c.scene.staleness.hold_end = std::chrono::milliseconds(400);
  c.scene.staleness.fade_end = std::chrono::milliseconds(500);
  c.passivity.tank.enabled = what.tank;
  c.passivity.device_damping = VecA::Constant(1, test::HandMass::kDamping);
  return c;
}

struct Aim {
  double at{0.0}, rate{0.0};  ///< m, m/s
};

Aim aim(const WallLoop& what, double t) {
  const double since = std::max(t - kBegin_s, 0.0);
  if (!what.cycles) {
    const double out = kCentre - kWallAmplitude;
    const double rise = 0.8;  // s
    return {out + hw::minimum_jerk(since / rise) * (kPressDepth - out), 0.0};
  }
  const double w = 2.0 * M_PI;
  const double rate = t < kBegin_s ? 0.0 : kWallAmplitude * w * std::sin(w * since);
  return {kCentre - kWallAmplitude * std::cos(w * since), rate};
}

/// Sums that become figures.
struct Sums {
  double drag{0.0}, squares{0.0};
  int outside{0}, late{0};
};

void account(const core::TickRecord& record, double v, bool late, WallFigures& f, Sums& sums) {
  const double force = std::abs(record.tau_a[0]);
  f.top_speed = std::max(f.top_speed, std::abs(v));
  f.peak_force = std::max(f.peak_force, force);
  f.throttled += record.limiters.has(core::Limiter::kEnergyTank) ? 1 : 0;
  if (record.q[0] < 0.0) {
    ++sums.outside;
    sums.drag += force;
  }
  if (!late) return;
  ++sums.late;
  sums.squares += v * v;
}

}  // namespace

WallFigures run(const WallLoop& what) {
  const double seconds = what.cycles ? 8.0 : 4.0;
  const int total = static_cast<int>((kBegin_s + seconds) * 1000.0);
  test::PipelineLoop loop(pipeline_for(what),
                          client_of(what.kind, what.network, core::VecX::Zero(1)),
                          test::HandMass::kDamping);
  test::HandMass mass(aim(what, 0.0).at);
  WallFigures figures;
  Sums sums;
  for (int k = 1; k <= total; ++k) {
    const double t = k * test::PipelineLoop::kTick_s;
    constexpr double dt = test::PipelineLoop::kTick_s / kSubsteps;
    for (int s = kSubsteps - 1; s >= 0; --s) {
      const Aim hand = aim(what, t - s * dt);
      mass.step(dt, loop.tau(), hand.at, hand.rate);
    }
    if (k == static_cast<int>(kEngage_s * 1000.0)) loop.engage();
    const core::TickRecord& record = loop.tick(VecQ::Constant(1, mass.q()));
    if (t < kBegin_s) continue;
    account(record, mass.v(), k > total - 1000, figures, sums);
    const bool at_the_end = std::abs(mass.q()) >= test::HandMass::kReach;
    if (at_the_end) {  // what follows is the end's doing
      figures.top_speed = figures.rms_speed = HUGE_VAL;
      break;
    }
  }
  loop.require_engaged();
  figures.drag = sums.drag / std::max(sums.outside, 1);
  if (sums.late > 0) figures.rms_speed = std::sqrt(sums.squares / sums.late);
  figures.most_given = loop.energy().most_given();
  figures.most_net = loop.energy().most_net();
  return figures;
}

bool stable(const WallLoop& what, const WallFigures& figures) noexcept {
  constexpr double kStill = 1e-3;  // m/s, METHOD 5.4
  constexpr double kFastestHand = 2.0 * M_PI * kWallAmplitude;
  return what.cycles ? figures.top_speed <= 2.0 * kFastestHand : figures.rms_speed < kStill;
}

double grid_stiffness(int n) noexcept {
  return 25.0 * std::pow(1.1, n);
}

double largest_stiffness(WallLoop what) {
  constexpr int kStride = 4;
  const auto holds = [&what](int n) {
    what.stiffness = grid_stiffness(n);
    return stable(what, run(what));
  };
  int good = -1;
  while (good + kStride <= kTop && holds(good + kStride)) good += kStride;
  for (int end = std::min(good + kStride - 1, kTop); good < end && holds(good + 1);) ++good;
  return good < 0 ? 0.0 : grid_stiffness(good);
}

}  // namespace haptic::report
