#include "tests/report/rtt_study.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "haptic/client/estimator.hpp"
#include "haptic/core/error.hpp"
#include "tests/report/analysis/vibration.hpp"
#include "tests/support/loop/local_laws.hpp"
#include "tests/support/loop/pipeline_loop.hpp"
#include "tests/support/plane_set.hpp"

namespace haptic::report {
namespace {

using core::VecX;

constexpr double kEngage_s = 1.0;  // ten samples at 30 Hz, 200 ms late, some lost
constexpr double kBegin_s = 1.4;   // the gain's ramp is over

bool holds_force(RttPeer peer) {
  return peer == RttPeer::kHeldForce || peer == RttPeer::kTdpa;
}

int tick_of(double t) {
  return static_cast<int>(std::lround(t / test::PipelineLoop::kTick_s));
}

std::chrono::nanoseconds span(double s) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(std::llround(1e9 * s)));
}

/// One step of the simulation with a look at the device.
std::function<void(test::Frame&)> simulation(const RttScene& scene,
                                             const std::shared_ptr<RttObject>& world,
                                             const RttRun& how, const RttHorizon& near) {
  const RttPeer peer = how.peer;
  const std::shared_ptr<RttObject> object = scene.one_world ? world : scene.object();
  std::vector<client::VirtualCoordinate> coordinates;
  for (const core::Coordinate& c : scene.pipeline.kinematics->space().coordinates()) {
    coordinates.push_back({c.name, c.unit == core::Unit::kMetre ? "m" : "rad", "linear"});
  }
  const auto estimator = std::make_shared<client::ContactEstimator>(coordinates, scene.blocks);
  return [=, blocks = scene.blocks](test::Frame& frame) {
    frame.x = object->proxy(frame.computed_s, frame.x_probe);
    if (peer == RttPeer::kHeld || holds_force(peer)) return;
    const std::vector<double> x_probe = to_std(frame.x_probe);
    std::vector<client::Plane> planes;
    if (peer == RttPeer::kContacts) {
      planes = object->contacts(frame.computed_s, frame.x, near);
    } else if (peer == RttPeer::kEstimated && frame.x == frame.x_probe) {
      estimator->free();
    } else if (peer == RttPeer::kEstimated) {
      planes = estimator->contacts(to_std(frame.x), x_probe);
    } else {
      planes = client::derive_planes(coordinates, to_std(frame.x), x_probe, blocks);
    }
    client::keep_deepest(coordinates, to_std(frame.x), x_probe, planes);
    frame.walls = test::plane_set(planes, static_cast<int>(frame.x.size()));
    frame.anchored = peer != RttPeer::kPlanes && !planes.empty();
  };
}

test::ClientSettings client_for(const RttScene& scene, const std::shared_ptr<RttObject>& world,
                                const RttRun& how) {
  constexpr double kEveryTick_hz = 1000.0;
  test::ClientSettings client;
  const bool planes = how.peer == RttPeer::kContacts || how.peer == RttPeer::kEstimated ||
                      how.peer == RttPeer::kPlanes;
  client.mode = planes ? core::ProxyMode::kPlanes : core::ProxyMode::kHeld;
  client.rate_hz = how.rate_hz;
  client.jitter = how.rate_hz < kEveryTick_hz ? 0.3 : 0.0;
  client.delay_s = how.round_trip_s;
  client.lost = how.lost;
  if (holds_force(how.peer)) client.between = test::held_deviation();
  // 1 ns: a round trip that is known to be none.
  const double period = 1.0 / how.rate_hz;
  const RttHorizon near{
      client::contact_horizon(span(std::max(how.round_trip_s, 1e-9)), span(period)),
      0.5 * (how.round_trip_s + period)};
  client.simulate = simulation(scene, world, how, near);
  return client;
}

core::PipelineConfig without_tank(core::PipelineConfig config) {
  config.passivity.tank.enabled = config.passivity.observer.enabled = false;
  return config;
}

/// Time-domain passivity control (B. Hannaford and J.-H. Ryu, IEEE T-RA 18(1):1-10, 2002): a
/// damper takes what the held force gave beyond what was put in.
class TimeDomainPassivity {
 public:
  /// `most`: of the damper, N s/m.
  explicit TimeDomainPassivity(double most) : most_(most) {}

  /// The damper's force over the next tick, after `way` (n_a, m) under the force `held`.
  [[nodiscard]] core::VecA step(const core::VecA& held, const core::VecA& way) noexcept {
    constexpr double dt = test::PipelineLoop::kTick_s;
    taken_ -= held.dot(way);
    const double square = way.squaredNorm() / dt;  // J per N s/m and tick
    const double damper = square > 0.0 ? std::clamp(-taken_ / square, 0.0, most_) : 0.0;
    return -damper / dt * way;
  }

 private:
  double most_;
  double taken_{0.0};  ///< J
};

/// The world's part of a tick, before anybody looks.
void advance(const RttScene& scene, RttObject& object, double t, const core::VecQ& q) {
  const core::Kinematics& map = *scene.pipeline.kinematics;
  VecX x_probe = VecX::Zero(map.space().n_x());
  if (map.position(q, x_probe) == core::MapStatus::kOk) object.advance(t, x_probe);
}

}  // namespace

RttFigures run(const RttScene& scene, const RttRun& how,
               const std::function<void(const RttTick&)>& observe) {
  const RttRun local{.rate_hz = 1000.0};
  const std::shared_ptr<RttObject> object = scene.object();
  test::PipelineLoop felt(holds_force(how.peer) ? without_tank(scene.pipeline) : scene.pipeline,
                          client_for(scene, scene.own ? scene.own() : object, how),
                          scene.device_damping);
  core::PipelineConfig ideal_config = without_tank(scene.pipeline);
  ideal_config.filter = {.rate_lag = ideal_config.filter.rate_lag};  // it gets what came of them
  test::PipelineLoop shadow(ideal_config, client_for(scene, object, local), scene.device_damping);
  const bool quiet = how.noise == SensorNoise::kNone;
  const std::unique_ptr<RttBody> body = scene.body();
  const core::DofLayout& layout = scene.pipeline.kinematics->layout();
  Sensors sensors(how.noise, *scene.pipeline.kinematics, 1);
  std::vector<double> offs;
  TimeDomainPassivity damper(scene.most_damping);
  test::EnergyBook book(scene.device_damping);
  ShadowJudge judge, bound;
  RttFigures figures;
  std::uint64_t last = 0;
  long samples = 0;
  const int ticks = tick_of(kBegin_s + scene.seconds), begins = tick_of(kBegin_s);
  core::VecA tau = core::VecA::Zero(layout.n_a()), q_a = layout.select(body->q());
  for (int k = 1; k <= ticks; ++k) {
    const double t = k * test::PipelineLoop::kTick_s;
    if (k == tick_of(kEngage_s)) {
      for (test::PipelineLoop* loop : {&felt, &shadow}) loop->engage();
    }
    body->step(t - kBegin_s, tau);
    advance(scene, *object, t, body->q());
    const core::VecA way = layout.select(body->q()) - q_a;
    q_a += way;
    book.add(tau, way, test::PipelineLoop::kTick_s);
    const core::TickRecord& record = felt.tick(sensors.read(body->q()));
    const core::TickRecord& ideal = shadow.tick(quiet ? record.sensed.q : body->q());
    const core::VecA control =
        how.peer == RttPeer::kTdpa ? damper.step(tau, way) : core::VecA::Zero(layout.n_a());
    tau = felt.tau_a() + control;
    if (k == begins) {
      for (test::PipelineLoop* loop : {&felt, &shadow}) loop->require_engaged();
    }
    if (k <= begins) continue;
    samples += record.proxy.seq != std::exchange(last, record.proxy.seq) ? 1 : 0;
    figures.ended = figures.ended || record.life.state != core::LifecycleState::kEngaged;
    ShadowTick tick{.felt = tau,
                    .shadow = shadow.tau_a(),
                    .elastic = record.effort.tau_elastic + control,
                    .touching = ideal.anchor.in_the_way,
                    .held_back = record.limiters().has(core::Limiter::kEnergyTank),
                    .clearance = object->clearance(t, felt.x_probe())};
    judge.add(tick);
    offs.push_back(tau[0] - shadow.tau());
    // The elastic force is compared, before tank and guard of the shadow's pipeline.
    tick.felt = record.effort.tau_elastic;
    tick.shadow = record.life.gain * scene.pipeline.scene.stiffness.cwiseProduct(
                                         ideal.anchor.stretch(layout, ideal.sensed.q));
    tick.bound = record.effort.error_bound;
    bound.add(tick);
    if (observe) observe({t - kBegin_s, tau[0], shadow.tau()});
  }
  figures.shadow = judge.figures();
  figures.bound = bound.figures();
  figures.most_net = book.most_net();
  figures.band = run_band_rms(offs);
  figures.ideal_net = shadow.energy().most_net();
  figures.samples_hz = static_cast<double>(samples) / scene.seconds;
  if (holds_force(how.peer)) {
    figures.samples_hz = how.rate_hz * (1.0 - how.lost);  // the local law makes one of every tick
  }
  return figures;
}

}  // namespace haptic::report
