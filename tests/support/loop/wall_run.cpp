#include "tests/support/loop/wall_run.hpp"

#include <algorithm>
#include <cmath>

#include "tests/support/loop/pipeline_loop.hpp"
#include "tests/support/loop/rails.hpp"

namespace haptic::test {
namespace {

using core::VecA;

constexpr HandOnMass kMass{.mass = 0.15, .damping = 1.0, .hand = 300.0, .hand_damping = 2.0};
constexpr double kReach = 0.19;        // m, ends of the device
constexpr double kEngage_s = 0.6;      // ten samples at 30 Hz, 100 ms late, and some
constexpr double kRamp_s = 0.3;        // then the gain's ramp is over
constexpr double kCentre = -0.002;     // m, of the hand's cycle
constexpr double kPressDepth = 0.020;  // m, target of the pressing hand
constexpr double kRise_s = 0.8;        // of the press

core::PipelineConfig pipeline_for(const WallRun& what) {
  // The ladder of proto/README.md#staleness-and-gain has its own tests; here a slow client is still
  // a client.
  core::PipelineConfig c = patient_rail();
  c.scene.stiffness[0] = what.stiffness;
  c.passivity = what.passivity;
  return c;
}

/// When the hand begins, s. Ten samples take longer if some are lost or out of order.
double begin_of(const WallRun& what) {
  const double arrive = (1.0 - what.client.lost) * (what.client.disorder ? 0.5 : 1.0);
  return kEngage_s / arrive + kRamp_s;
}

/// `since` the hand began, s; negative before.
HandAim aim(const WallRun& what, double since) {
  const auto one = [](double value) { return core::VecQ(core::VecQ::Constant(1, value)); };
  if (!what.cycles) {
    const double out = kCentre - kWallAmplitude;
    const double u = std::clamp(since / kRise_s, 0.0, 1.0);
    const double way = u * u * u * (10.0 + u * (6.0 * u - 15.0));  // minimum jerk
    return {one(out + way * (kPressDepth - out)), one(0.0)};
  }
  const double w = 2.0 * M_PI, phase = w * std::max(since, 0.0);
  return {one(kCentre - kWallAmplitude * std::cos(phase)),
          one(kWallAmplitude * w * std::sin(phase))};
}

/// Sums that become figures.
struct Sums {
  double drag{0.0}, squares{0.0};
  int outside{0}, late{0};
};

void account(const core::TickRecord& record, double wall, const HandMasses& mass, bool late,
             WallFigures& f, Sums& sums) {
  const double force = std::abs(record.effort.tau_a[0]);
  const double q = mass.q()[0], v = mass.v()[0];
  f.top_speed = std::max(f.top_speed, std::abs(v));
  f.largest_q = std::max(f.largest_q, std::abs(q));
  f.peak_force = std::max(f.peak_force, force);
  f.throttled += record.limiters().has(core::Limiter::kEnergyTank) ? 1 : 0;
  if (record.sensed.q[0] < wall) {
    ++sums.outside;
    sums.drag += force;
  }
  if (!late) return;
  ++sums.late;
  sums.squares += v * v;
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
  p.device_damping = VecA::Constant(1, kMass.damping);
  return p;
}

WallFigures run(const WallRun& what) {
  const double begin = begin_of(what), seconds = what.cycles ? 8.0 : 4.0;
  const int total = static_cast<int>((begin + seconds) * 1000.0);
  const int engage = static_cast<int>((begin - kRamp_s) * 1000.0);
  PipelineLoop loop(pipeline_for(what), what.client, kMass.damping);
  HandMasses mass([&](double t) { return aim(what, t - begin); }, kMass);
  WallFigures figures;
  Sums sums;
  for (int k = 1; k <= total; ++k) {
    const double t = k * PipelineLoop::kTick_s;
    mass.step(t, loop.tau_a());
    if (k == engage) loop.engage();
    const core::TickRecord& record = loop.tick(mass.q());
    if (t < begin) continue;
    account(record, what.client.stop[0], mass, k > total - 1000, figures, sums);
    if (std::abs(mass.q()[0]) >= kReach) {
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
