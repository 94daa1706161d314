#pragma once
/// The experiment of core/METHOD.md#forces-at-the-finger: a finger that wears the exoskeleton
/// presses against stops of its joints; a client without delay stops the proxy there in every tick
/// of 1 ms.

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "hw/simulated/finger_physics.hpp"
#include "tests/support/angles.hpp"

namespace haptic::hw::test {

inline constexpr double kNoStop = 999.0;

/// Angles in degrees, (MCP, PIP).
struct Press {
  Eigen::Vector2d stop{18.0, kNoStop};
  Eigen::Vector2d target{50.0, 50.0};  ///< reached in 0.8 s from the straight finger
  /// Where set, the user's aim over time (s) instead of the rise to `target`.
  std::function<Eigen::Vector2d(double)> aim{};
  double stiffness{1500.0};  ///< N/m
  bool force{true};
  bool planes{false};  ///< the stops as planes, 60 samples a second, instead of a held proxy
  core::RendererKind renderer{core::RendererKind::kSubspaceLinear};
  bool direction_guard{false};
  double seconds{2.0};
  core::PassivitySettings passivity{};
};

struct Pressed {
  Eigen::Vector2d end{};    ///< finger at the end, deg
  double penetration{0.0};  ///< largest over a joint and the second half, deg
  double work{0.0};         ///< of the actuator's force on the exoskeleton, J
  double most_net{0.0};     ///< largest over time of that less the actuator's damping, J
  double mean_force{0.0};   ///< |tau_a|, N
  double peak_force{0.0};   ///< N
  double end_force{0.0};    ///< N
  double least_power{0.0};  ///< smallest tau_x . dx, N m rad: below 0 the finger is pulled away
  double debt{0.0};         ///< of the tank, largest, J
  int throttled{0};         ///< ticks that the tank held back
  int ticks{0};
};

inline core::PipelineConfig pipeline_of(const Press& press) {
  core::PipelineConfig c{.kinematics = core::make_finger_exoskeleton(core::finger_sign_change())};
  c.device.q_lower = (core::VecQ(2) << -0.005, -1.5).finished();
  c.device.q_upper = (core::VecQ(2) << 0.055, 0.85).finished();
  c.device.max_effort = core::VecA::Constant(1, 40.0);
  c.scene.renderer = press.renderer;
  c.scene.direction_guard = press.direction_guard;
  c.scene.stiffness = core::VecA::Constant(1, press.stiffness);
  c.scene.damping = core::VecA::Zero(1);
  c.scene.force_limit = core::VecA::Constant(1, 40.0);
  c.scene.slew_limit = core::VecA::Constant(1, 1e7);
  c.scene.engage_window = core::VecA::Constant(1, 1e6);
  c.passivity = press.passivity;
  return c;
}

/// A tank that holds `initial` (J; 0 = strictly passive) on a device of the simulated actuator's
/// damping.
inline core::PassivitySettings tank_of(double initial) {
  core::PassivitySettings p;
  p.tank.enabled = true;
  p.tank.initial = initial;
  p.device_damping = core::VecA::Constant(1, FingerParameters{}.actuator_damping);
  return p;
}

/// tau_x . dx of core/METHOD.md#forces-at-the-finger, from the test's own 2 x 2 inverse.
inline double power_towards(const core::Kinematics& kinematics, const core::TickRecord& r) {
  core::VecX x_probe(2);
  core::MatXQ J(2, 2);
  if (kinematics.evaluate(r.sensed.q, x_probe, J) != core::MapStatus::kOk) return 0.0;
  const double det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
  const Eigen::Vector2d w(J(1, 1) / det, -J(0, 1) / det);
  return r.effort.tau_elastic[0] *
         (w[0] * (r.anchor.x[0] - x_probe[0]) + w[1] * (r.anchor.x[1] - x_probe[1]));
}

inline Pressed run(const Press& press) {
  constexpr double kTick = 1e-3;
  constexpr int kSubsteps = 10, kSettle = 600;
  const FingerParameters parameters{};
  core::Pipeline pipeline(pipeline_of(press));
  FingerPhysics finger(parameters, pipeline.config().kinematics, Eigen::Vector2d::Zero());
  const Eigen::Vector2d stop = press.stop * kDegree;
  core::TickInput in{.settings = pipeline.config().scene};
  in.device.fresh = in.device.armed = true;
  in.command.tenure = 1;
  in.command.lease_held = true;
  in.proxy.tenure = 1;
  in.proxy.x.resize(2);
  if (press.planes) {
    in.proxy.mode = core::ProxyMode::kPlanes;
    in.proxy.planes.normals = core::MatXQ::Identity(2, 2);
    in.proxy.planes.offsets = stop;
  }

  Pressed out;
  double net = 0.0, motion = 0.0, tau = 0.0;
  const int total = kSettle + static_cast<int>(press.seconds * 1000.0);
  for (int k = 0; k < total; ++k) {
    in.now += std::chrono::milliseconds(1);
    in.device.sample.seq = static_cast<std::uint64_t>(k + 1);
    in.device.sample.time = in.now;
    in.device.sample.q = finger.q();
    if (in.proxy.gapless_samples++ == 0) in.proxy.gapless_since = in.now;
    in.proxy.born = in.now;
    if (!press.planes || k % 17 == 0) {
      ++in.proxy.seq;
      for (int j = 0; j < 2; ++j) in.proxy.x[j] = std::min(finger.x()[j], stop[j]);
    }
    if (!press.planes) {  // free at first: the finger comes from outside
      in.proxy.mode = k == 0 ? core::ProxyMode::kFree : core::ProxyMode::kHeld;
    }
    if (k == kSettle / 2 && press.force) ++in.command.engage_id;
    const core::TickRecord record = pipeline.tick(in);
    tau = press.force ? record.effort.tau_a[0] : 0.0;

    const double t = (k - kSettle) * kTick;
    const auto aim = [&press](double at) -> Eigen::Vector2d {
      if (press.aim) return press.aim(std::max(at, 0.0)) * kDegree;
      return std::clamp(at / 0.8, 0.0, 1.0) * press.target * kDegree;
    };
    const double l = finger.q()[0];
    for (int s = 1; s <= kSubsteps; ++s) {
      finger.step(kTick / kSubsteps, aim(t + s * kTick / kSubsteps), tau);
    }
    const double dl = finger.q()[0] - l;
    if (k < kSettle) continue;
    ++out.ticks;
    out.work += tau * dl;
    motion += dl * dl / kTick;
    net = out.work - parameters.actuator_damping * motion;
    out.most_net = std::max(out.most_net, net);
    out.mean_force += std::abs(tau);
    out.peak_force = std::max(out.peak_force, std::abs(tau));
    out.debt = std::max(out.debt, -record.effort.passivity.tank);
    out.throttled += record.effort.passivity.throttled ? 1 : 0;
    out.least_power =
        std::min(out.least_power, power_towards(*pipeline.config().kinematics, record));
    if (k > total - static_cast<int>(press.seconds * 500.0)) {
      for (int j = 0; j < 2; ++j) {
        out.penetration = std::max(out.penetration, (finger.x()[j] - stop[j]) / kDegree);
      }
    }
  }
  out.mean_force /= out.ticks;
  out.end = finger.x() / kDegree;
  out.end_force = tau;
  return out;
}

}  // namespace haptic::hw::test
