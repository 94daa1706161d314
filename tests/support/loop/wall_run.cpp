#include "tests/support/loop/wall_run.hpp"

#include <algorithm>
#include <cmath>

#include "haptic/core/model/linear.hpp"
#include "tests/support/loop/pipeline_loop.hpp"

namespace haptic::test {
namespace {

using core::VecA;
using core::VecQ;

constexpr double kEngage_s = 0.6;      // ten samples at 30 Hz, 100 ms late, and some
constexpr double kRamp_s = 0.3;        // then the gain's ramp is over
constexpr double kCentre = -0.002;     // m, of the hand's cycle
constexpr double kPressDepth = 0.020;  // m, target of the pressing hand
constexpr double kRise_s = 0.8;        // of the press
constexpr int kSubsteps = 10;

core::PipelineConfig pipeline_for(const WallRun& what) {
  core::LinearMap map{.dofs = {{"l", core::Unit::kMetre, true, -0.2, 0.2}},
                      .coordinates = {{"x", core::Unit::kMetre, core::CoordinateKind::kLinear}},
                      .A = core::MatXQ::Identity(1, 1),
                      .x_0 = core::VecX::Zero(1)};
  core::PipelineConfig c{.kinematics = core::make_linear(map)};
  c.device.q_lower = VecQ::Constant(1, -1.0);
  c.device.q_upper = VecQ::Constant(1, 1.0);
  c.device.max_effort = VecA::Constant(1, 100.0);
  c.scene.stiffness = VecA::Constant(1, what.stiffness);
  c.scene.damping = VecA::Zero(1);
  c.scene.force_limit = VecA::Constant(1, 60.0);
  c.scene.slew_limit = VecA::Constant(1, 1e7);
  c.scene.engage_window = VecA::Constant(1, 60.0);
  // The ladder of proto/README.md#staleness-and-gain has its own tests; here a slow client is still
  // a client.
  c.scene.staleness.hold_end = std::chrono::milliseconds(400);
  c.scene.staleness.fade_end = std::chrono::milliseconds(500);
  c.passivity = what.passivity;
  return c;
}

/// When the hand begins, s. Ten samples take longer if some are lost or out of order.
double begin_of(const WallRun& what) {
  const double arrive = (1.0 - what.client.lost) * (what.client.disorder ? 0.5 : 1.0);
  return kEngage_s / arrive + kRamp_s;
}

struct Aim {
  double at{0.0}, rate{0.0};  ///< m, m/s
};

/// `since` the hand began, s; negative before.
Aim aim(const WallRun& what, double since) {
  if (!what.cycles) {
    const double out = kCentre - kWallAmplitude;
    const double u = std::clamp(since / kRise_s, 0.0, 1.0);
    const double way = u * u * u * (10.0 + u * (6.0 * u - 15.0));  // minimum jerk
    return {out + way * (kPressDepth - out), 0.0};
  }
  const double w = 2.0 * M_PI, phase = w * std::max(since, 0.0);
  return {kCentre - kWallAmplitude * std::cos(phase), kWallAmplitude * w * std::sin(phase)};
}

/// Sums that become figures.
struct Sums {
  double drag{0.0}, squares{0.0};
  int outside{0}, late{0};
};

void account(const core::TickRecord& record, double wall, const HandMass& mass, bool late,
             WallFigures& f, Sums& sums) {
  const double force = std::abs(record.effort.tau_a[0]);
  f.top_speed = std::max(f.top_speed, std::abs(mass.v()));
  f.largest_q = std::max(f.largest_q, std::abs(mass.q()));
  f.peak_force = std::max(f.peak_force, force);
  f.throttled += record.limiters().has(core::Limiter::kEnergyTank) ? 1 : 0;
  if (record.sensed.q[0] < wall) {
    ++sums.outside;
    sums.drag += force;
  }
  if (!late) return;
  ++sums.late;
  sums.squares += mass.v() * mass.v();
}

}  // namespace

WallRun wall_run(core::ProxyMode mode) {
  WallRun run;
  run.client.mode = mode;
  run.client.stop = core::VecX::Zero(1);
  run.client.delay_s = 0.020;
  return run;
}

core::PassivitySettings wall_tank(double initial) {
  core::PassivitySettings p;
  p.tank.enabled = true;
  p.tank.initial = initial;
  p.device_damping = VecA::Constant(1, HandMass::kDamping);
  return p;
}

WallFigures run(const WallRun& what) {
  const double begin = begin_of(what), seconds = what.cycles ? 8.0 : 4.0;
  const int total = static_cast<int>((begin + seconds) * 1000.0);
  const int engage = static_cast<int>((begin - kRamp_s) * 1000.0);
  PipelineLoop loop(pipeline_for(what), what.client, HandMass::kDamping);
  HandMass mass(aim(what, -begin).at);
  WallFigures figures;
  Sums sums;
  for (int k = 1; k <= total; ++k) {
    const double t = k * PipelineLoop::kTick_s;
    constexpr double dt = PipelineLoop::kTick_s / kSubsteps;
    for (int s = kSubsteps - 1; s >= 0; --s) {
      const Aim hand = aim(what, t - s * dt - begin);
      mass.step(dt, loop.tau(), hand.at, hand.rate);
    }
    if (k == engage) loop.engage();
    const core::TickRecord& record = loop.tick(VecQ::Constant(1, mass.q()));
    if (t < begin) continue;
    account(record, what.client.stop[0], mass, k > total - 1000, figures, sums);
    if (std::abs(mass.q()) >= HandMass::kReach) {
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

}  // namespace haptic::test
