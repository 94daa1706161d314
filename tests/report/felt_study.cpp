#include "tests/report/felt_study.hpp"

#include <algorithm>
#include <cmath>

#include "haptic/core/error.hpp"
#include "hw/simulated/hand.hpp"
#include "server/owner/scene/scene.hpp"
#include "server/owner/scene/shipped.hpp"
#include "tests/report/analysis/vibration.hpp"
#include "tests/report/best_force.hpp"
#include "tests/report/finger_press.hpp"
#include "tests/support/cpu_time.hpp"
#include "tests/support/loop/pipeline_loop.hpp"

namespace haptic::report {
namespace {

using core::VecX;

constexpr const char* kScene = "finger_soft_grasp";  // the demo's
constexpr double kEngage_s = 0.7;  // ten samples at 30 Hz, 100 ms late, jitter, and some
constexpr double kLeave_s = 1.0;   // the gain's ramp is over

int tick_of(double t) {
  return static_cast<int>(std::lround(t / test::PipelineLoop::kTick_s));
}

core::PipelineConfig config_of(const FeltDevice& device, core::RendererKind renderer) {
  core::PipelineConfig config = device.pipeline;
  config.scene.renderer = renderer;
  config.passivity.tank.initial = 0.0;  // stricter than the scene: what is given was put in
  return config;
}

/// A simulation that tells its contacts: planes of walls, or the disc with its curvature.
std::function<void(test::Frame&)> contacts_of(const FeltTrajectory& what) {
  return [what](test::Frame& frame) {
    frame.walls = what.object(frame.x_probe);
    frame.x = frame.x_probe;
    for (int i = 0; i < frame.walls.size(); ++i) {  // their normals are perpendicular
      const auto n = frame.walls.normals.col(i);
      frame.x -= std::max(0.0, n.dot(frame.x) - frame.walls.offsets[i]) * n;
    }
    frame.contact = frame.x != frame.x_probe;
    frame.anchored = true;
    if (!what.round) return;
    const Eigen::Vector2d out = -frame.walls.normals.col(0);
    const double distance = out.dot(Eigen::Vector2d(frame.x) - what.centre);
    const Eigen::Matrix2d H =
        (Eigen::Matrix2d::Identity() - out * out.transpose()) / distance;  // of the gap
    frame.walls.curvature.resize(3);
    frame.walls.curvature << H(0, 0), H(1, 0), H(1, 1);
    frame.walls.curved[0] = 2;
  };
}

}  // namespace

test::ClientSettings client_of(const FeltTrajectory& what, ClientKind kind,
                               const Network& network) {
  test::ClientSettings client = client_of(kind, network, {});
  if (kind == ClientKind::kContacts) {
    client.simulate = contacts_of(what);
  } else {
    client.object = what.object;
  }
  client.seed = static_cast<std::uint64_t>(what.motion) + 1;
  return client;
}

FeltSums& FeltSums::operator+=(const FeltSums& other) noexcept {
  ticks += other.ticks;
  limited += other.limited;
  throttled += other.throttled;
  guarded += other.guarded;
  error2 += other.error2;
  ideal2 += other.ideal2;
  over2 += other.over2;
  best2 += other.best2;
  all2 += other.all2;
  ideal_all2 += other.ideal_all2;
  band2 += other.band2;
  ended += other.ended;
  return *this;
}

FeltDevice felt_device(std::shared_ptr<const core::Kinematics> finger) {
  const auto file = server::find_scene(kScene);
  if (!file) throw core::SceneError(std::string("felt: no scene ") + kScene);
  const server::DeviceScene scene = server::load_scene(*file).devices.front();
  const auto* source = dynamic_cast<const hw::SimulatedHandConfig*>(scene.source.get());
  if (source == nullptr) throw core::SceneError("felt: the scene has no simulated finger");
  FeltDevice device;
  device.finger = source->finger;
  const auto opened = source->open(finger, scene.pipeline.loop_late_fault);
  device.pipeline = server::pipeline_config(scene, opened->info().limits);
  device.pipeline.kinematics = std::move(finger);
  device.pipeline.derating = false;  // peers are compared at one stiffness
  return device;
}

FeltSums run(const FeltTrajectory& what, const FeltDevice& device, const FeltRun& with,
             FeltInputs* inputs) {
  const core::PipelineConfig config = config_of(device, with.renderer);
  const double damping = device.finger.actuator_damping;
  test::PipelineLoop felt(config, client_of(what, with.client, with.network), damping);
  core::PipelineConfig unfiltered = config;
  unfiltered.filter = {};
  test::PipelineLoop ideal(unfiltered, client_of(what, ClientKind::kPlanes, {1000.0, 0.0}),
                           damping);
  hw::FingerPhysics physics(device.finger, config.kinematics, what.aim(0.0));
  BestForce best(config.kinematics->space(), config.scene.stiffness[0],
                 config.scene.force_limit[0]);
  Sensors sensors(with.noise, *config.kinematics, static_cast<std::uint64_t>(what.motion) + 1);
  FeltSums sums;
  std::vector<double> offs;
  const int begins = tick_of(kLeave_s), last = tick_of(kLeave_s + kFeltSeconds);
  for (int k = 1; k <= last; ++k) {
    if (k == tick_of(kEngage_s)) {
      felt.engage();
      ideal.engage();
    }
    const double t = k * test::PipelineLoop::kTick_s - kLeave_s;
    if (k > begins) step_tick(physics, t, what.aim, felt.tau());
    const core::TickRecord& record = felt.tick(sensors.read(physics.q()));
    const core::LimiterSet limiters = record.limiters() | ideal.tick(physics.q()).limiters();
    if (inputs != nullptr) {
      (k > begins ? inputs->motion : inputs->before).push_back({record.input, felt.proxy()});
    }
    if (k == begins) {
      felt.require_engaged();
      ideal.require_engaged();
    }
    if (k <= begins) continue;
    if (record.life.state != core::LifecycleState::kEngaged ||
        ideal.record().life.state != core::LifecycleState::kEngaged) {
      ++sums.ended;
      break;
    }
    const VecX w = lever(felt.J());
    const double w2 = w.squaredNorm(), off = felt.tau() - ideal.tau();
    offs.push_back(off);
    ++sums.ticks;
    sums.all2 += w2 * off * off;
    sums.ideal_all2 += w2 * ideal.tau() * ideal.tau();
    if (limiters.any()) {
      ++sums.limited;
      sums.throttled += limiters.has(core::Limiter::kEnergyTank) ? 1 : 0;
      sums.guarded += limiters.has(core::Limiter::kDirectionGuard) ? 1 : 0;
      continue;
    }
    const double tau = best.at(what.object(felt.x_probe()), felt.x_probe(), w);
    const double over = felt.tau() - tau;
    sums.error2 += w2 * off * off;
    sums.ideal2 += w2 * ideal.tau() * ideal.tau();
    sums.over2 += w2 * over * over;
    sums.best2 += w2 * tau * tau;
  }
  sums.band2 = std::pow(run_band_rms(offs), 2) * static_cast<double>(sums.ticks);
  return sums;
}

double replayed_tick_ns(const FeltDevice& device, core::RendererKind renderer,
                        const FeltInputs& inputs) {
  core::Pipeline pipeline(config_of(device, renderer));
  double force = 0.0;
  const auto tick = [&](const FeltInputs::Tick& at) { return pipeline.tick(at.input, at.proxy); };
  for (const auto& at : inputs.before) force += tick(at).life.gain;
  const double start = test::cpu_ns();
  for (const auto& at : inputs.motion) force += tick(at).effort.tau_a[0];
  const double spent = test::cpu_ns() - start;
  if (!std::isfinite(force)) throw core::SceneError("felt: a replayed force is not finite");
  return spent / static_cast<double>(inputs.motion.size());
}

}  // namespace haptic::report
