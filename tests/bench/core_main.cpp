/// haptic-bench-core: what one tick costs, and what the choices inside it cost. Their errors:
/// haptic-report work-precision.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "haptic/core/contacts/plane_projection.hpp"
#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/rendering/renderer.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "tests/bench/paired.hpp"
#include "tests/bench/single_calls.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/pressing_hand.hpp"

namespace {

using namespace haptic;
using core::VecA;
using core::VecQ;
using core::VecX;

constexpr int kPoses = 512;

/// Poses along a grasp, and the proxy that a stop at 18 and 25 degrees makes of each.
struct Poses {
  std::unique_ptr<core::Kinematics> finger = core::make_finger_exoskeleton({});
  std::vector<VecQ> q{}, q_star{};
  std::vector<VecX> x{};

  Poses() {
    for (int i = 0; i < kPoses; ++i) {
      const double phase = 2.0 * M_PI * i / kPoses;
      VecX at(2), proxy(2);
      at << (22 + 8 * std::sin(phase)) * kDegree, (30 + 9 * std::sin(phase + 0.3)) * kDegree;
      proxy << std::min(at[0], 18 * kDegree), std::min(at[1], 25 * kDegree);
      VecQ pose, anchor;
      if (finger->inverse(at, pose) != core::InverseStatus::kExact ||
          finger->inverse(proxy, anchor) != core::InverseStatus::kExact) {
        std::fprintf(stderr, "a pose of the benchmark is out of reach\n");
        std::abort();
      }
      q.push_back(pose);
      q_star.push_back(anchor);
      x.push_back(proxy);
    }
  }
};

double sink = 0.0;

constexpr int kWarmUp = 1000, kTicks = 3000;

struct Tick {
  core::TickInput input{};
  core::ProxySnapshot proxy{};
};

/// Tick `i` (from 0, 1 ms apart) of an engaged device: the fresh sample q (n_q), and the held proxy
/// x (n_x) of a client at 60 Hz, free at first.
Tick held_tick(const core::PipelineConfig& config, int i, const core::VecQ& q,
               const core::VecX& x) {
  Tick tick;
  core::TickInput& input = tick.input;
  input.now = core::TimePoint(std::chrono::milliseconds(i + 1));
  input.settings = config.scene;
  input.device.fresh = input.device.armed = true;
  input.device.sample.seq = static_cast<std::uint64_t>(i);
  input.device.sample.time = input.now;
  input.device.sample.q = q;
  input.command.tenure = 1;
  input.command.lease_held = true;
  input.command.engage_id = i > 250 ? 1 : 0;
  tick.proxy.mode = i == 0 ? core::ProxyMode::kFree : core::ProxyMode::kHeld;
  tick.proxy.tenure = 1;
  tick.proxy.seq = static_cast<std::uint64_t>(i / 16 + 1);
  tick.proxy.gapless_samples = static_cast<std::uint64_t>(i);
  tick.proxy.born = input.now;
  tick.proxy.x = x;
  return tick;
}

Tick tick_at(const Poses& poses, const core::PipelineConfig& config, int i) {
  return held_tick(config, i, poses.q[static_cast<std::size_t>(i % kPoses)],
                   poses.x[static_cast<std::size_t>((i / 16 * 16) % kPoses)]);
}

/// Parts that a scene may add to a tick.
struct Extras {
  const char* name{""};
  bool guard{false}, tank{false}, observer{false};
  int planes{0};
  bool laws{false};   ///< the planes give way and curve
  bool bound{false};  ///< their stiffness is told within 10 %, and the sample is anchored
};

core::PipelineConfig tick_config(const std::shared_ptr<const core::Kinematics>& map,
                                 const core::RendererKind kind, const Extras& extras) {
  core::PipelineConfig config = pressing_config(map, kind);
  config.scene.direction_guard = extras.guard;
  config.passivity.tank.enabled = extras.tank;
  config.passivity.observer.enabled = extras.observer;
  config.passivity.observer.inertia = VecA::Constant(map->layout().n_a(), 0.05);
  return config;
}

/// Stops of MCP, PIP and of their sum, all of them pressed: MCP and PIP hold, the sum is redundant.
void put_planes(int count, core::ProxySnapshot& proxy) {
  const double normals[3][3] = {
      {1.0, 0.0, 18 * kDegree}, {0.0, 1.0, 25 * kDegree}, {1.0, 1.0, 43.5 * kDegree}};
  proxy.mode = core::ProxyMode::kPlanes;
  proxy.planes.normals.resize(2, count);
  proxy.planes.offsets.resize(count);
  for (int k = 0; k < count; ++k) {
    proxy.planes.normals.col(k) << normals[k][0], normals[k][1];
    proxy.planes.offsets[k] = normals[k][2];
  }
}

/// A third of the coupling's stiffness, and the curvature of a fingertip on a disc.
void put_laws(core::PlaneSet& planes) {
  planes.compliance.setConstant(planes.size(), 3.0);
  planes.curvature.resize(3 * planes.size());
  for (int i = 0; i < planes.size(); ++i) {
    planes.curvature.segment(3 * i, 3) << 0.4, 0.2, 0.3;
    planes.curved[static_cast<std::size_t>(i)] = 2;
  }
}

double tick_p50(const Poses& poses, core::RendererKind kind, const Extras& extras) {
  const core::PipelineConfig config = tick_config(core::make_finger_exoskeleton({}), kind, extras);
  core::Pipeline pipeline(config);
  bool engaged = false;
  const double p50 = bench::p50_of_calls(
      kWarmUp, kTicks,
      [&](int i) {
        Tick tick = tick_at(poses, config, i);
        if (extras.planes > 0) put_planes(extras.planes, tick.proxy);
        if (extras.laws) put_laws(tick.proxy.planes);
        if (extras.bound) {
          tick.proxy.planes.uncertainty.setConstant(extras.planes, 0.1);
          tick.proxy.anchored_at = static_cast<std::uint64_t>(std::max(i / 16 * 16 - 1, 1));
        }
        return tick;
      },
      [&](const Tick& tick) {
        const core::TickRecord record = pipeline.tick(tick.input, tick.proxy);
        engaged = record.life.state == core::LifecycleState::kEngaged;
        sink += record.effort.tau_a[0];
      });
  if (!engaged) std::abort();  // a tick without force would be too cheap
  return p50;
}

/// Five fingers in one grasp; each has two soft, curved contacts.
double hand_tick_p50(const Poses& poses) {
  constexpr int kFingers = 5, kContacts = 2;
  std::vector<core::HandFinger> fingers;
  for (int k = 0; k < kFingers; ++k) fingers.push_back({std::to_string(k), {}});
  const core::PipelineConfig config = tick_config(
      core::make_hand_exoskeleton(fingers), core::RendererKind::kSubspaceLinear, {.tank = true});
  core::Pipeline pipeline(config);
  bool felt = false;
  const double p50 = bench::p50_of_calls(
      kWarmUp, kTicks,
      [&](int i) {
        const Tick one = tick_at(poses, config, i);
        Tick tick = held_tick(config, i, one.input.device.sample.q.replicate(kFingers, 1),
                              one.proxy.x.replicate(kFingers, 1));
        core::ProxySnapshot of_one;
        put_planes(kContacts, of_one);
        core::PlaneSet& planes = tick.proxy.planes;
        tick.proxy.mode = of_one.mode;
        planes.normals.setZero(2 * kFingers, kContacts * kFingers);
        planes.offsets = of_one.planes.offsets.replicate(kFingers, 1);
        for (int k = 0; k < kFingers; ++k) {
          planes.normals.block(2 * k, kContacts * k, 2, kContacts) = of_one.planes.normals;
        }
        put_laws(planes);
        for (int k = 0; k < planes.size(); ++k) {
          planes.first[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(k / kContacts * 2);
        }
        return tick;
      },
      [&](const Tick& tick) {
        const core::TickRecord record = pipeline.tick(tick.input, tick.proxy);
        sink += record.effort.tau_a[0];
        felt = felt || (record.life.state == core::LifecycleState::kEngaged &&
                        record.anchor.active_planes == (1u << kContacts * kFingers) - 1);
      });
  if (!felt) std::abort();  // a tick without force would be too cheap
  return p50;
}

/// us of the longest replay that a sample of pushed objects costs.
double replay_us(int contacts, bool curved) {
  const core::ConfigurationSpace space(std::vector<core::Coordinate>(4));
  core::PlaneSet set;
  set.normals = core::MatXQ::Constant(4, contacts, 0.1);
  for (int i = 0; i < contacts; ++i) set.normals(i % 4, i) = 1.0 + 0.1 * i;
  set.offsets.setZero(contacts);
  put_laws(set);
  if (!curved) {
    set.curvature.resize(0);
    set.curved = {};
  }
  set.laws.setConstant(4, contacts, 1e-3);
  core::PlaneProjection projection(space);
  VecX x, probe = VecX::Constant(4, 0.01);
  return 1e-3 * bench::ns_per_call(20, [&](int calls) {
           for (int n = 0; n < calls; ++n) {
             projection.set(set, VecX::Zero(4));
             for (int k = projection.replayable(); k > 0; --k) {
               probe[0] = 0.01 + 1e-5 * k;
               static_cast<void>(projection.project(probe, x, 0.0, 1e-3, 1));
             }
             sink += x[0];
           }
         });
}

}  // namespace

int main() {
  const Poses poses;
  const core::Kinematics& finger = *poses.finger;
  const VecA Z_q = VecA::Constant(1, 1500.0);
  VecX x_probe, dx;
  core::MatXQ J;
  bench::print_header();

  for (const core::RendererKind kind :
       {core::RendererKind::kStandard, core::RendererKind::kNullSpace,
        core::RendererKind::kSubspaceLinear, core::RendererKind::kSubspaceExact,
        core::RendererKind::kPerContact}) {
    for (const Extras& extras :
         {Extras{}, Extras{" with guard", true}, Extras{" with tank", false, true},
          Extras{" with 3 planes", false, false, false, 3},
          Extras{" with 3 planes, guard, tank, observer", true, true, true, 3}}) {
      bench::print(bench::measure(
          "tick " + std::string(core::name(kind)) + extras.name + " p50", "ns",
          [&] { return tick_p50(poses, kind, extras); }, extras.planes > 0 ? 2000.0 : 1000.0));
    }
  }

  constexpr core::RendererKind kEq8 = core::RendererKind::kSubspaceLinear;
  for (const int planes : {1, 3}) {
    const Extras contacts{"", false, false, false, planes};
    const std::string with = " with " + std::to_string(planes) + " contacts p50";
    bench::print(bench::compare(
        "tick per_contact" + with, "tick subspace_linear" + with, "ns",
        [&] { return tick_p50(poses, core::RendererKind::kPerContact, contacts); },
        [&] { return tick_p50(poses, kEq8, contacts); }, planes == 1 ? 1.3 : 0.0));
  }

  const Extras soft{" with 3 soft curved contacts, tank", false, true, false, 3, true};
  bench::print(bench::measure(
      "tick subspace_linear" + std::string(soft.name) + " p50", "ns",
      [&] { return tick_p50(poses, kEq8, soft); }, 1200.0));

  Extras bounded = soft;
  bounded.bound = true;
  const std::string told = "tick subspace_linear" + std::string(soft.name);
  bench::print(bench::compare(
      told + ", bound p50", told + " p50", "ns", [&] { return tick_p50(poses, kEq8, bounded); },
      [&] { return tick_p50(poses, kEq8, soft); }, 0.0));
  bench::print(bench::measure(
      "tick hand of five with 10 soft curved contacts, tank p50", "ns",
      [&] { return hand_tick_p50(poses); }, 6000.0));

  for (const int contacts : {1, 3, 10}) {
    for (const bool curved : {false, true}) {
      const std::string what = "replay of " + std::to_string(contacts) + " pushed objects";
      bench::print(bench::measure(
          what + (curved ? ", curved" : ""), "us", [=] { return replay_us(contacts, curved); },
          20.0));
    }
  }

  core::LeastSquares solver(2, finger.layout());
  const auto look = [&](const VecQ& q, std::size_t k) {  // f, J, dx
    static_cast<void>(finger.evaluate(q, x_probe, J));
    finger.space().difference(poses.x[k], x_probe, dx);
  };
  VecQ q_star = poses.q_star[0];
  const auto ours = [&](std::size_t k) {
    look(poses.q[k], k);
    solver.solve(J, dx, Z_q);
    sink += solver.dq()[0];
  };
  const auto eigen = [&](std::size_t k) {  // the formula as it stands in the paper
    static_cast<void>(finger.evaluate(poses.q[k], x_probe, J));
    const Eigen::Matrix2d J2 = J;
    const Eigen::Vector2d d = poses.x[k] - x_probe;
    const Eigen::Vector2d dq = (J2.transpose() * J2).llt().solve(J2.transpose() * d);
    sink += dq[0];
  };
  const auto warm_step = [&](std::size_t k) {  // one Gauss-Newton step from the previous q*
    look(q_star, k);
    solver.solve(J, dx, Z_q);
    q_star += solver.dq();
    sink += q_star[0];
  };
  const auto closed_form = [&](std::size_t k) {
    static_cast<void>(finger.inverse(poses.x[k], q_star));
    sink += q_star[0];
  };
  const auto block = [](const auto& solve) {  // the poses in turn
    return bench::ns_block(16384, [&solve](int n) {
      for (int i = 0; i < n; ++i) solve(static_cast<std::size_t>(i % kPoses));
    });
  };
  bench::print(bench::compare("Eq. (8) f + J + solve", "fixed-size Eigen (J^T J)^-1 J^T dx by LLT",
                              "ns", block(ours), block(eigen), 1.0));
  bench::print(bench::compare("Eq. (6) one warm Gauss-Newton step", "Eq. (8)", "ns",
                              block(warm_step), block(ours), 1.2));
  bench::print(
      bench::compare("Eq. (6) closed form", "Eq. (8)", "ns", block(closed_form), block(ours), 1.5));
  std::fprintf(stderr, "%s",
               sink == 0.123 ? "\n" : "");  // keeps the work from being optimised away
  return 0;
}
