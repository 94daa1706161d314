#pragma once
/// The experiment of METHOD 5.4: a mass on one actuated DoF, moved in and out of a wall by a hand,
/// the simulation behind a network with a rate, a delay, jitter and worse.

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>

#include "haptic/core/model/linear.hpp"
#include "haptic/core/tick/pipeline.hpp"

namespace haptic::core::test {

struct WallRun {
  double stiffness{1500.0};  ///< N/m
  ProxyMode mode{ProxyMode::kPlanes};
  bool derived{false};      ///< the plane is known only while the simulation sees contact
  double rate{60.0};        ///< of the simulation, Hz
  double delay{0.020};      ///< from state to sample's arrival, s
  double jitter{0.3};       ///< share of the period
  double lost{0.0};         ///< share of frames dropped
  bool disorder{false};     ///< frames arrive twice and out of order
  double wall{0.0};         ///< m
  double centre{-0.002};    ///< of the hand's motion, m
  double amplitude{0.020};  ///< m
  double hertz{1.0};
  double seconds{8.0};
  PassivitySettings passivity{};
};

struct WallResult {
  double most_net{0.0};   ///< largest over t of work on the device less its damping, J
  double largest_q{0.0};  ///< m
  double drag{0.0};       ///< mean |tau| while outside the wall, N
  double peak{0.0};       ///< N
  int throttled{0};
  int outside{0};  ///< ticks
};

inline constexpr double kWallMass = 0.15, kWallDamping = 1.0;  // kg, N s/m

inline PipelineConfig wall_config(const WallRun& run) {
  LinearMap map;
  map.dofs = {{"l", Unit::kMetre, true, -0.2, 0.2}};
  map.coordinates = {{"x", Unit::kMetre, CoordinateKind::kLinear}};
  map.A = MatXQ::Identity(1, 1);
  map.x_0 = VecX::Zero(1);
  PipelineConfig c;
  c.kinematics = make_linear(map);
  c.device.q_lower = VecQ::Constant(1, -1.0);
  c.device.q_upper = VecQ::Constant(1, 1.0);
  c.device.max_effort = VecA::Constant(1, 100.0);
  c.scene.stiffness = VecA::Constant(1, run.stiffness);
  c.scene.damping = VecA::Zero(1);
  c.scene.force_limit = VecA::Constant(1, 60.0);
  c.scene.slew_limit = VecA::Constant(1, 1e7);
  c.scene.engage_window = VecA::Constant(1, 1e6);
  c.scene.staleness.hold_end = std::chrono::milliseconds(400);
  c.scene.staleness.fade_end = std::chrono::milliseconds(500);
  c.passivity = run.passivity;
  return c;
}

/// One frame on its way.
struct WallFrame {
  double arrives{0.0};
  std::uint64_t seq{0};
  double x{0.0};
  bool contact{false};
};

inline WallResult run_wall(const WallRun& run) {
  constexpr double kTick = 1e-3, kSettle = 1.2, kHandStiffness = 300.0, kHandDamping = 2.0;
  Pipeline pipeline(wall_config(run));
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::deque<WallFrame> network;
  TickInput in;
  in.settings = pipeline.config().scene;
  in.device.fresh = in.device.armed = true;
  in.command.lease_epoch = 1;
  in.command.lease_held = true;
  in.proxy.epoch = 1;
  WallResult result;
  double q = run.centre - run.amplitude, v = 0.0, work = 0.0, motion = 0.0, next_frame = 0.0;
  std::uint64_t seq = 0;
  const int total = static_cast<int>((run.seconds + kSettle) / kTick);
  for (int k = 0; k < total; ++k) {
    const double t = k * kTick;
    if (t >= next_frame) {  // the simulation sees the device now, its answer arrives later
      next_frame += (1.0 + run.jitter * unit(random)) / run.rate;
      const bool dropped = t > kSettle && 0.5 * (unit(random) + 1.0) < run.lost;
      const double late = run.disorder ? std::abs(unit(random)) * 2.0 / run.rate : 0.0;
      const double at = std::min(q, run.wall);
      ++seq;
      if (!dropped) network.push_back({t + run.delay + late, seq, at, q > run.wall});
      if (!dropped && run.disorder)
        network.push_back({t + run.delay + 2.0 * late, seq, at, q > run.wall});
    }
    in.now += std::chrono::milliseconds(1);
    for (const WallFrame& frame : network) {
      if (frame.arrives > t || frame.seq <= in.proxy.seq) continue;  // as the ingress does
      in.proxy.seq = frame.seq;
      in.proxy.mode = run.mode;
      in.proxy.x = VecX::Constant(1, frame.x);
      const int planes = run.mode == ProxyMode::kPlanes && (frame.contact || !run.derived) ? 1 : 0;
      in.proxy.planes.normals.setOnes(1, planes);
      in.proxy.planes.offsets.setConstant(planes, run.wall);
      in.proxy.born = in.now;
      if (in.proxy.gapless_samples++ == 0) in.proxy.gapless_since = in.now;
    }
    std::erase_if(network, [t](const WallFrame& frame) { return frame.arrives <= t; });
    in.device.sample.seq = static_cast<std::uint64_t>(k + 1);
    in.device.sample.time = in.now;
    in.device.sample.q = VecQ::Constant(1, q);
    if (t > kSettle - 0.3 && in.command.engage_id == 0) ++in.command.engage_id;
    const TickRecord record = pipeline.tick(in);

    const double from = q, tau = record.tau_a[0];
    for (int s = 1; s <= 10; ++s) {
      const double phase = 2.0 * M_PI * run.hertz * std::max(t + s * 1e-4 - kSettle, 0.0);
      const double aim = run.centre - run.amplitude * std::cos(phase);
      const double aim_dot =
          t < kSettle ? 0.0 : run.amplitude * 2.0 * M_PI * run.hertz * std::sin(phase);
      const double force = kHandStiffness * (aim - q) + kHandDamping * (aim_dot - v) + tau;
      v = (v + 1e-4 * force / kWallMass) / (1.0 + 1e-4 * kWallDamping / kWallMass);
      q += 1e-4 * v;
      if (std::abs(q) > 0.19) v = 0.0;  // the stops of the device
      q = std::clamp(q, -0.19, 0.19);
    }
    if (t < kSettle) continue;
    work += tau * (q - from);
    motion += (q - from) * (q - from) / kTick;
    result.most_net = std::max(result.most_net, work - kWallDamping * motion);
    result.largest_q = std::max(result.largest_q, std::abs(q));
    result.peak = std::max(result.peak, std::abs(tau));
    result.throttled += record.passivity.throttled ? 1 : 0;
    if (from < run.wall) {
      ++result.outside;
      result.drag += std::abs(tau);
    }
  }
  result.drag /= std::max(result.outside, 1);
  return result;
}

inline PassivitySettings wall_tank(double initial) {
  PassivitySettings p;
  p.tank.enabled = true;
  p.tank.initial = initial;
  p.device_damping = VecA::Constant(1, kWallDamping);
  return p;
}

}  // namespace haptic::core::test
