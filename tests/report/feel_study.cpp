#include "tests/report/feel_study.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/report/analysis/vibration.hpp"
#include "tests/report/best_force.hpp"
#include "tests/report/finger_press.hpp"
#include "tests/support/loop/pipeline_loop.hpp"

namespace haptic::report {
namespace {

constexpr double kEngage_s = 0.7, kLeave_s = 1.0;     // as felt
constexpr double kRest_s = 1.2;                       // of a press, after the way
constexpr std::size_t kSteady = 512, kSegment = 256;  // ticks of a spectrum
constexpr int kOnset = 5, kAfterSample = 3;           // ticks, because of the slew limit
constexpr double kPhalanx = 0.025;                    // m

int tick_of(double t) {
  return static_cast<int>(std::lround(t / test::PipelineLoop::kTick_s));
}

core::PipelineConfig config_of(const FeltDevice& device, bool tank) {
  core::PipelineConfig config = device.pipeline;
  config.derating = true;
  config.passivity.tank.enabled = config.passivity.tank.enabled && tank;
  config.passivity.observer.enabled = config.passivity.observer.enabled && tank;
  return config;
}
core::PipelineConfig plain(core::PipelineConfig config) {
  config.scene.renderer = core::RendererKind::kSubspaceLinear;
  config.scene.direction_guard = false;
  return config;
}

core::PipelineConfig unfiltered(core::PipelineConfig config) {
  config.filter = {};
  return config;
}

/// One tick's forces in a row, of which the spectra are made.
struct Series {
  std::vector<double> tau{}, untanked{}, lever{};  ///< N, N, m/rad of the PIP
  std::vector<Eigen::Vector2d> x{}, w{};
  std::vector<char> touching{};

  void add(const FeelTick& tick, const core::VecX& lever_now, bool in_contact) {
    tau.push_back(tick.tau);
    untanked.push_back(tick.untanked);
    lever.push_back(lever_now[1]);
    x.push_back(tick.x);
    w.emplace_back(lever_now[0], lever_now[1]);
    touching.push_back(in_contact ? 1 : 0);
  }
  [[nodiscard]] Vibration at(std::size_t from, std::size_t n, const std::vector<double>& force,
                             const hw::FingerParameters& finger) const {
    const std::span<const double> part(force.data() + from, n);
    std::vector<double> tip;
    for (std::size_t i = from; i < from + n; ++i) tip.push_back(force[i] * lever[i] / kPhalanx);
    const std::size_t middle = from + n / 2;
    const auto felt = [&](double hz) {
      // The threshold is a peak's: times the square root of 2 for the rms.
      return tip_compliance(finger, x[middle], w[middle], hz) * std::numbers::sqrt2 /
             vibration_threshold(hz);
    };
    return {band_rms(part), band_rms(tip), band_rms(part, felt)};
  }
  /// The last part of a press, or all segments in contact, half over each other.
  [[nodiscard]] Vibration all(bool press, const std::vector<double>& force,
                              const hw::FingerParameters& finger) const {
    if (press) return at(tau.size() - kSteady, kSteady, force, finger);
    Vibration sum;
    int segments = 0;
    for (std::size_t from = 0; from + kSegment <= tau.size(); from += kSegment / 2) {
      const auto begin = touching.begin() + static_cast<std::ptrdiff_t>(from);
      if (std::count(begin, begin + kSegment, 0) > 0) continue;
      const Vibration one = at(from, kSegment, force, finger);
      sum.actuator += one.actuator * one.actuator;
      sum.tip += one.tip * one.tip;
      sum.weighted += one.weighted * one.weighted;
      ++segments;
    }
    const double n = std::max(segments, 1);
    return {std::sqrt(sum.actuator / n), std::sqrt(sum.tip / n), std::sqrt(sum.weighted / n)};
  }
};

/// Steps of the force and their causes, and what comes and goes.
class Steps {
 public:
  void see(const core::TickRecord& felt, const core::TickRecord& without, const FeelTick& tick,
           FeelFigures& figures) {
    const bool touching = felt.anchor.in_the_way;
    const std::uint32_t planes = touching ? felt.anchor.active_planes : 0;
    onset_ = touching != touching_ || planes != planes_ ? kOnset : onset_ - 1;
    sample_ = felt.proxy.seq != seq_ ? kAfterSample : sample_ - 1;
    const double plain = tick.plain - last_.plain, untanked = tick.untanked - last_.untanked;
    const double rule = beyond(untanked, plain), tank = beyond(tick.tau - last_.tau, untanked);
    const bool throttles = felt.limiters().has(core::Limiter::kEnergyTank);
    const core::LimiterSet by = without.limiters();
    const bool guards = by.has(core::Limiter::kDirectionGuard);
    if (begun_) {
      note(FeelCause::kTank, tank, figures);
      note(guards || guarded_ ? FeelCause::kGuard : FeelCause::kBand, rule, figures);
      note(onset_ > 0    ? FeelCause::kOnset
           : sample_ > 0 ? FeelCause::kSample
                         : FeelCause::kMotion,
           std::abs(plain), figures);
      figures.rough += throttles && tank > kFeltStep ? 1 : 0;
      for (const core::Limiter limiter :
           {core::Limiter::kEnergyTank, core::Limiter::kDirectionGuard, core::Limiter::kContacts}) {
        figures.toggles += felt.limiters().has(limiter) != limiters_.has(limiter) ? 1 : 0;
      }
    }
    figures.throttled += throttles ? 1 : 0;
    figures.contact += touching ? 1 : 0;
    begun_ = true;
    guarded_ = guards;
    touching_ = touching;
    planes_ = planes;
    seq_ = felt.proxy.seq;
    limiters_ = felt.limiters();
    last_ = tick;
  }

 private:
  /// How far a step is outside of what lies between none and the other: what is felt of it more.
  static double beyond(double step, double other) noexcept {
    return std::max({0.0, step - std::max(other, 0.0), std::min(other, 0.0) - step});
  }
  static void note(FeelCause cause, double step, FeelFigures& figures) {
    double& most = figures.step[static_cast<std::size_t>(cause)];
    most = std::max(most, step);
  }

  bool begun_{false}, touching_{false}, guarded_{false};
  std::uint32_t planes_{0};
  std::uint64_t seq_{0};
  int onset_{0}, sample_{0};  ///< ticks left
  core::LimiterSet limiters_{};
  FeelTick last_{};
};

/// The pipelines.
struct Loops {
  test::PipelineLoop felt, untanked, plain, clean, ideal;

  Loops(const FeelTask& task, const core::PipelineConfig& with, const core::PipelineConfig& without,
        double damping)
      : felt(with, task.remote, damping),
        untanked(without, task.remote, damping),
        plain(report::plain(without), task.remote, damping),
        clean(unfiltered(without), task.remote, damping),
        ideal(unfiltered(without), task.ideal, damping) {}
  void engage() {
    for (test::PipelineLoop* loop : {&felt, &untanked, &plain, &clean, &ideal}) loop->engage();
  }
  void tick(const core::VecQ& reading, const core::VecQ& q) {
    for (test::PipelineLoop* loop : {&felt, &untanked, &plain}) {
      static_cast<void>(loop->tick(reading));
    }
    for (test::PipelineLoop* loop : {&clean, &ideal}) static_cast<void>(loop->tick(q));
  }
  /// Forces of this tick.
  [[nodiscard]] FeelTick forces() const {
    const core::TickRecord& record = felt.record();
    const core::VecA& derated = record.derating.stiffness;
    const double share = derated.size() > 0 ? derated[0] / record.input.settings.stiffness[0] : 1.0;
    FeelTick tick;
    tick.tau = felt.tau();
    tick.untanked = untanked.tau();
    tick.plain = plain.tau();
    tick.clean = clean.tau();
    tick.ideal = share * ideal.tau();
    tick.limiters = record.limiters();
    return tick;
  }
};

/// Adds a tick to the sums of torques.
void account(const FeelTick& tick, double w2, FeelFigures& figures) {
  const auto square = [w2](double force) { return w2 * force * force; };
  figures.force += std::abs(tick.tau) * test::PipelineLoop::kTick_s;
  figures.error2 += square(tick.tau - tick.ideal);
  figures.ideal2 += square(tick.ideal);
  figures.added2 += square(tick.tau - tick.clean);
  figures.clean2 += square(tick.clean);
}

}  // namespace

double FeelFigures::guard_step() const noexcept {
  return std::max(step[static_cast<std::size_t>(FeelCause::kGuard)],
                  step[static_cast<std::size_t>(FeelCause::kBand)]);
}

FeelTask feel_task(const RandomPress& press) {
  FeelTask task{press.index, true, name(press.walls), kPressClients[press.client].name};
  task.seconds = press.rise_s + kRest_s;
  task.aim = [press](double t) { return aim_of(press, t); };
  task.remote = client_of(press);
  task.ideal = client_of(ClientKind::kPlanes, {1000.0, 0.0}, {});
  task.ideal.walls = press.planes;
  return task;
}

FeelTask feel_task(const FeltTrajectory& motion, int index) {
  const PressClient& client = kPressClients[static_cast<std::size_t>(motion.motion) % 4];
  FeelTask task{index, false, motion.round ? "round" : "flat", client.name, kFeltSeconds};
  task.aim = motion.aim;
  task.remote = client_of(motion, client.kind, client.network);
  task.ideal = client_of(motion, ClientKind::kPlanes, {1000.0, 0.0});
  return task;
}

FeelFigures run(const FeelTask& task, const FeltDevice& device, const FeelRun& with,
                const std::function<void(const FeelTick&)>& observe) {
  hw::FingerParameters finger = device.finger;
  finger.actuator_friction += with.drive.friction;
  const core::PipelineConfig config = config_of(device, with.tank);
  Loops loops(task, config, config_of(device, false), finger.actuator_damping);
  hw::FingerPhysics physics(finger, config.kinematics, task.aim(0.0));
  Sensors sensors(with.noise, *config.kinematics, static_cast<std::uint64_t>(task.index) + 1);
  test::EnergyBook book(finger.actuator_damping);
  Series series;
  Steps steps;
  FeelFigures figures;
  figures.tank_0 = config.passivity.tank.initial;
  double l_x = physics.q()[0];
  const int begins = tick_of(kLeave_s), last = tick_of(kLeave_s + task.seconds);
  for (int k = 1; k <= last; ++k) {
    if (k == tick_of(kEngage_s)) loops.engage();
    const double t = k * test::PipelineLoop::kTick_s - kLeave_s;
    const double cogging = with.drive.cogging * std::sin(2.0 * std::numbers::pi * l_x / kCogging_m);
    const double held = loops.felt.tau();
    if (k > begins) step_tick(physics, t, task.aim, held - cogging);
    const core::VecA way = core::VecA::Constant(1, physics.q()[0] - l_x);
    book.add(core::VecA::Constant(1, held), way, test::PipelineLoop::kTick_s);
    l_x = physics.q()[0];
    loops.tick(sensors.read(physics.q()), physics.q());
    if (k == begins) loops.felt.require_engaged();
    if (k <= begins) continue;
    const core::TickRecord& record = loops.felt.record();
    figures.ended = figures.ended || record.life.state != core::LifecycleState::kEngaged;
    FeelTick tick = loops.forces();
    tick.t_s = t;
    tick.x = physics.x();
    const core::VecX w = lever(loops.ideal.J());
    steps.see(record, loops.untanked.record(), tick, figures);
    series.add(tick, w, loops.ideal.record().anchor.in_the_way);
    account(tick, w.squaredNorm(), figures);
    if (observe) observe(tick);
  }
  figures.felt = series.all(task.press, series.tau, finger);
  figures.untanked = series.all(task.press, series.untanked, finger);
  figures.net = book.most_net();
  figures.given = book.most_given();
  return figures;
}

}  // namespace haptic::report
