#include "tests/report/press_study.hpp"

#include <algorithm>
#include <cmath>

#include "haptic/core/error.hpp"
#include "hw/motion/minimum_jerk.hpp"
#include "tests/report/analysis/vibration.hpp"
#include "tests/report/best_force.hpp"
#include "tests/report/finger_press.hpp"
#include "tests/support/link/random.hpp"
#include "tests/support/loop/pipeline_loop.hpp"

namespace haptic::report {
namespace {

using core::VecA;
using core::VecX;

constexpr double kEngage_s = 0.6;    // ten samples at 60 Hz, 20 ms late, and some
constexpr double kLeave_s = 0.9;     // the gain's ramp is over
constexpr double kRest_s = 1.2;      // after the way: the end state
constexpr double kJudged_deg = 0.5;  // depth from which felt torque is judged
constexpr double kLeverage = 0.002;  // m/rad: below it a wall cannot be pushed
constexpr double kOff = 0.1;         // felt torque is off beyond this share of the optimum
constexpr double kSmall = 0.05;      // N: no matter

core::PipelineConfig pipeline_for(const RandomPress& press, const PressRun& with,
                                  std::shared_ptr<const core::Kinematics> finger) {
  core::PipelineConfig config = finger_pipeline(std::move(finger), with.renderer, press.stiffness);
  config.derating = true;
  config.filter = core::kDefaultFilter;
  config.scene.direction_guard = with.guard;
  config.passivity.tank.enabled = with.tank.has_value();
  config.passivity.tank.initial = with.tank.value_or(0.0);
  config.passivity.device_inertia = VecA::Constant(1, hw::FingerParameters{}.actuator_mass);
  return config;
}

Eigen::Vector2d degrees(const Pair& deg) {
  return Eigen::Vector2d(deg.first, deg.second) * kDegree;
}

/// Figures that run along with a press.
struct Judge {
  const RandomPress& press;
  BestForce best;
  double deepest[2]{-1e9, -1e9}, strongest{0.0}, last_tau{0.0};
  double ripple_sum{0.0};
  int ripples{0};
  bool throttled{false};  ///< in the last tick

  Judge(const RandomPress& what, const core::Kinematics& finger)
      : press(what), best(finger.space(), press.stiffness, kFingerForceLimit) {}
  void see(const test::PipelineLoop& loop, PressStudyTick& tick);
  void account(const PressStudyTick& tick, bool engaged, bool resting, PressFigures& figures);
};

void Judge::see(const test::PipelineLoop& loop, PressStudyTick& tick) {
  const VecX& probe = loop.x_probe();
  const VecX w = lever(loop.J());
  for (int i = 0; i < press.planes.size(); ++i) {
    tick.depth_deg[i] =
        (press.planes.normals.col(i).dot(probe) - press.planes.offsets[i]) / kDegree;
    tick.away[i] = -press.planes.normals.col(i).dot(w);
  }
  tick.optimum = best.at(press.planes, probe, w);
}

void Judge::account(const PressStudyTick& tick, bool engaged, bool resting, PressFigures& figures) {
  const int n = press.planes.size();
  bool deep = false, contact = false, leverage = false, grows = false;
  for (int i = 0; i < n; ++i) {
    figures.end_deg[i] = tick.depth_deg[i];
    figures.peak_deg[i] = std::max(figures.peak_deg[i], tick.depth_deg[i]);
    contact = contact || tick.depth_deg[i] > 0.0;
    deep = deep || tick.depth_deg[i] > kJudged_deg;
    leverage = leverage || (tick.depth_deg[i] > 0.0 && std::abs(tick.away[i]) > kLeverage);
    if (tick.depth_deg[i] * kDegree > kContactBand && tick.away[i] * tick.tau_a < -1e-9)
      ++figures.pushed_in;
    if (tick.depth_deg[i] > deepest[i]) {
      grows = tick.depth_deg[i] > kJudged_deg;
      deepest[i] = tick.depth_deg[i];
    }
  }
  figures.end_force = tick.tau_a;
  figures.peak_force = std::max(figures.peak_force, std::abs(tick.tau_a));
  const bool throttles = tick.limiters.has(core::Limiter::kEnergyTank);
  if (engaged && (throttles || throttled)) {
    figures.throttled_step =
        std::max(figures.throttled_step,
                 std::abs(tick.tau_a) > 0.0 || contact ? std::abs(tick.tau_a - last_tau) : 0.0);
  }
  throttled = throttles;
  if (resting) {
    ripple_sum += (tick.tau_a - last_tau) * (tick.tau_a - last_tau);
    ++ripples;
  }
  last_tau = tick.tau_a;
  figures.ripple = ripples > 0 ? std::sqrt(ripple_sum / ripples) : 0.0;
  if (!engaged || !contact) return;
  ++figures.contact;
  const bool limited = tick.limiters.any();
  figures.limited += limited ? 1 : 0;
  if (tick.optimum == 0.0 || !leverage) ++figures.unrenderable;
  if (deep && !limited) {
    ++figures.judged;
    const double off = std::abs(tick.tau_a - tick.optimum);
    if (off > kOff * std::abs(tick.optimum) && off > kSmall) ++figures.off;
  }
  if (n == 1 && grows && leverage) {
    strongest = std::max(strongest, std::abs(tick.tau_a));
    if (strongest > 0.2) {
      figures.weakest = std::min(figures.weakest, std::abs(tick.tau_a) / strongest);
    }
  }
}

}  // namespace

test::ClientSettings client_of(const RandomPress& press) {
  const PressClient& how = kPressClients[press.client];
  test::ClientSettings client = client_of(how.kind, how.network, {});
  client.walls = press.planes;
  client.seed = static_cast<std::uint64_t>(press.index) + 1;
  return client;
}

Eigen::Vector2d aim_of(const RandomPress& press, double t) {
  const Eigen::Vector2d start = degrees(press.start_deg), aim = degrees(press.aim_deg);
  return start + hw::minimum_jerk(t / press.rise_s) * (aim - start);
}

double default_tank(const RandomPress& press) {
  const double window = 0.25 * 25.0;
  return 0.5 * window * window / press.stiffness;
}

RandomPress random_press(std::uint64_t seed, int index, const core::Kinematics& finger) {
  test::Random random(seed, static_cast<std::uint64_t>(index));
  const auto between = [&](double a, double b) { return a + (b - a) * random.uniform(); };
  RandomPress press;
  press.index = index;
  press.client = static_cast<std::size_t>(index) % kPressClients.size();
  press.walls = static_cast<WallKind>((index / 4) % 4);
  core::VecQ q = core::VecQ::Zero(2);
  const auto reached = [&](const Eigen::Vector2d& x) {
    return finger.inverse(VecX(x), q) == core::InverseStatus::kExact;
  };
  for (int tries = 0; tries < 10000; ++tries) {
    press.start_deg = {between(2, 30), between(2, 40)};
    press.aim_deg = {between(10, 78), between(10, 88)};
    const double depth = between(3, 20), other = between(3, 20), angle = between(-20, 110);
    press.rise_s = std::exp(between(std::log(0.15), std::log(1.5)));
    press.stiffness = std::exp(between(std::log(500.0), std::log(6000.0)));
    const Eigen::Vector2d start = degrees(press.start_deg), aim = degrees(press.aim_deg);
    if (!reached(start) || !reached(aim)) continue;
    const int n = press.walls == WallKind::kBoth ? 2 : 1;
    press.planes.normals.resize(2, n);
    press.planes.offsets.resize(n);
    const Eigen::Vector2d slant(std::cos(angle * kDegree), std::sin(angle * kDegree));
    bool free = true;
    for (int i = 0; i < n; ++i) {
      Eigen::Vector2d normal = slant;
      if (press.walls == WallKind::kMcp || (press.walls == WallKind::kBoth && i == 0)) {
        normal = Eigen::Vector2d::UnitX();
      } else if (press.walls != WallKind::kSlanted) {
        normal = Eigen::Vector2d::UnitY();
      }
      press.planes.normals.col(i) = normal;
      press.planes.offsets[i] = normal.dot(aim) - (i == 0 ? depth : other) * kDegree;
      free = free && normal.dot(start) < press.planes.offsets[i] - 1.0 * kDegree;
    }
    if (free) return press;
  }
  throw core::SceneError("press: no random press fits the finger's reach");
}

PressFigures run(const RandomPress& press, const PressRun& with,
                 const std::shared_ptr<const core::Kinematics>& finger,
                 const std::function<void(const PressStudyTick&)>& observe) {
  hw::FingerPhysics physics({}, finger, degrees(press.start_deg));
  test::PipelineLoop loop(pipeline_for(press, with, finger), client_of(press), kFingerDamping);
  Sensors sensors(with.noise, *finger, static_cast<std::uint64_t>(press.index) + 1);
  test::EnergyBook book(kFingerDamping);
  std::vector<double> forces;
  Judge judge(press, *finger);
  PressFigures figures;
  const auto tick_of = [](double t) { return static_cast<int>(std::lround(t * 1000.0)); };
  const double end_s = kLeave_s + press.rise_s + kRest_s;
  const int last = tick_of(end_s);
  const auto hand = [&](double t) { return aim_of(press, t - kLeave_s); };
  for (int k = 1; k <= last; ++k) {
    const double t = k * test::PipelineLoop::kTick_s;
    if (with.force && k == tick_of(kEngage_s)) loop.engage();
    const double l_x = physics.q()[0];
    step_tick(physics, t, hand, loop.tau());
    book.add(loop.tau_a(), VecA::Constant(1, physics.q()[0] - l_x), test::PipelineLoop::kTick_s);
    const core::TickRecord& record = loop.tick(sensors.read(physics.q()));
    forces.push_back(loop.tau());
    PressStudyTick tick;
    tick.t_s = t - kLeave_s;
    tick.x_deg = {loop.x_probe()[0] / kDegree, loop.x_probe()[1] / kDegree};
    tick.tau_a = record.effort.tau_a[0];
    tick.given = book.given_in_all();
    tick.limiters = record.limiters();
    judge.see(loop, tick);
    const bool engaged = record.life.gain >= 1.0;
    if (record.life.gain > 0.0) {
      figures.throttled += record.limiters().has(core::Limiter::kEnergyTank) ? 1 : 0;
    }
    judge.account(tick, engaged, t > end_s - 0.3, figures);
    if (observe) observe(tick);
  }
  if (with.force) loop.require_engaged();
  figures.given = book.given_in_all();
  figures.most_given = book.most_given();
  figures.most_net = book.most_net();
  figures.band = band_rms(std::span<const double>(forces).last(512));
  return figures;
}

}  // namespace haptic::report
