#include "tests/bench/coupled_stiffness.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "haptic/core/model/stylus.hpp"
#include "haptic/core/passivity/spring_storage.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "tests/bench/p50_of_ticks.hpp"
#include "tests/bench/paired.hpp"
#include "tests/bench/tick_input.hpp"

namespace haptic::bench {

namespace {

using core::VecA;
using core::VecQ;
using core::VecX;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kPoses = 512;
constexpr double kWanted = 200.0;  // N/m at the wrist
constexpr double kTorque = 0.6;    // N m, of each actuator

/// The actuated part of dx/dq at the wrist, where the gimbal's axes meet; m/rad.
Matrix3d wrist_jacobian(const VecQ& q) {
  const auto wrist =
      core::make_stylus({}, {{"wrist", "gimbal_roll", core::OutputKind::kPoint, core::Pose3{}}});
  VecX x;
  core::MatXQ J;
  if (wrist->evaluate(q, x, J) != core::MapStatus::kOk) std::abort();
  return J.leftCols<3>();
}

/// A stylus that is moved about a proxy at rest, far enough that the coupled spring is at its limit
/// in half of the poses; the diagonal one, per actuator, in none.
struct Stylus {
  std::shared_ptr<const core::Kinematics> map = core::make_stylus({});
  VecQ rest = (VecQ(6) << 0, 0.9, -1.4, 0, 0.3, 0).finished();
  Matrix3d J_a = wrist_jacobian(rest);
  Matrix3d Z_q = kWanted * J_a.transpose() * J_a;  ///< N m/rad
  std::vector<VecQ> q{};
  VecX x{};

  Stylus() {
    core::MatXQ J;
    if (map->evaluate(rest, x, J) != core::MapStatus::kOk) std::abort();
    for (int i = 0; i < kPoses; ++i) {
      const double phase = 2 * M_PI * i / kPoses;
      VecQ at = rest;
      at.head<3>() += 0.062 * Vector3d(std::sin(phase), std::cos(phase), std::sin(phase + 2.0));
      q.push_back(at);
    }
  }
};

struct Choice {
  bool coupled{false}, tank_and_observer{false};
};

core::PipelineConfig config_of(const Stylus& stylus, const Choice& choice) {
  core::PipelineConfig c;
  c.kinematics = stylus.map;
  const auto& coordinates = stylus.map->space().coordinates();
  VecX scale(coordinates.size());
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    // core/METHOD.md#metric-and-limits: 5 mm count as 0.1 rad; a chord of quaternions is half the
    // angle.
    const bool metres = coordinates[i].unit == core::Unit::kMetre;
    scale[static_cast<Eigen::Index>(i)] = metres ? 0.005 : 0.05;
  }
  c.projection.metric = core::TaskMetric::from_scales(scale);
  if (choice.coupled) {
    c.projection.coupling = std::make_shared<const core::StiffnessCoupling>(stylus.Z_q);
  }
  c.device.q_lower = VecQ::Constant(6, -3.0);
  c.device.q_upper = VecQ::Constant(6, 3.0);
  c.device.max_effort = VecA::Constant(3, 0.8);
  c.scene.renderer = core::RendererKind::kSubspaceExact;
  c.scene.stiffness = stylus.Z_q.diagonal();
  c.scene.damping = VecA::Constant(3, 0.004);
  c.scene.force_limit = VecA::Constant(3, kTorque);
  c.scene.slew_limit = VecA::Constant(3, 1e3);
  c.scene.engage_window = VecA::Constant(3, 10.0);
  c.passivity.tank.enabled = choice.tank_and_observer;
  c.passivity.tank.initial = 0.01;
  c.passivity.observer.enabled = choice.tank_and_observer;
  c.passivity.observer.inertia = VecA::Constant(3, 3e-3);
  c.passivity.device_damping = VecA::Constant(3, 0.01);
  return c;
}

core::TickInput tick_input(const Stylus& stylus, const core::PipelineConfig& config, int i) {
  return held_tick(config, i, stylus.q[static_cast<std::size_t>(i % kPoses)], stylus.x);
}

double tick_p50(const Stylus& stylus, const Choice& choice) {
  const core::PipelineConfig config = config_of(stylus, choice);
  core::Pipeline pipeline(config);
  core::TickRecord record;
  const double p50 =
      bench::p50_of_ticks([&](int i) { return tick_input(stylus, config, i); },
                          [&](const core::TickInput& input) { record = pipeline.tick(input); });
  const bool force =
      record.life.state == core::DeviceState::kEngaged && record.effort.tau_elastic.norm() > 0.0;
  if (!force) std::abort();  // a tick without force would be a flattering figure
  return p50;
}

/// Joules that the user gets out of one slow cycle of q_a about the anchor, by the trapezoidal
/// rule: a circle of 0.25 rad across shoulder and elbow, half of it in saturation.
template <typename Force>
double cycle_work(const Force& force) {
  constexpr int kSteps = 20000;
  double work = 0.0;
  const auto at = [](int i) {
    const double phase = 2 * M_PI * i / kSteps;
    return Vector3d(0.0, 0.05 + 0.25 * std::cos(phase), -0.03 + 0.25 * std::sin(phase));
  };
  Vector3d before = at(0), tau_before = force(Vector3d(-before));
  for (int i = 1; i <= kSteps; ++i) {
    const Vector3d now = at(i), tau = force(Vector3d(-now));
    work += 0.5 * (tau + tau_before).dot(now - before);
    before = now;
    tau_before = tau;
  }
  return work;
}

void print_errors(const Stylus& stylus) {
  core::SpringStorage radial;
  radial.Z_q = stylus.Z_q;
  radial.stiffness = stylus.Z_q.diagonal();
  radial.gain = 1.0;
  static_cast<void>(radial.hold_within(VecA::Constant(3, kTorque)));
  double stored = 0.0;
  const double whole = cycle_work([&](const Vector3d& d) {
    stored = std::max(stored, radial.energy(VecA(d)));
    return Vector3d(radial.force(VecA(d)));
  });
  const double clamped = cycle_work([&](const Vector3d& d) {
    return Vector3d((stylus.Z_q * d).cwiseMax(-kTorque).cwiseMin(kTorque));
  });
  // In space: K_x = J_a^{-T} Z_q J_a^{-1}.
  const Matrix3d inverse = stylus.J_a.inverse(), diagonal = stylus.Z_q.diagonal().asDiagonal();
  const auto extent = [&](const Matrix3d& Z) {
    const Matrix3d K = inverse.transpose() * Z * inverse;
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(0.5 * (K + K.transpose()));
    return Vector3d(solver.eigenvalues());
  };
  const Vector3d K_coupled = extent(stylus.Z_q), K_diagonal = extent(diagonal);
  std::printf(
      "# stiffness at the wrist, %.0f N/m wanted in every direction: coupled Z_q %.6g to %.6g N/m; "
      "its diagonal %.4g to %.4g N/m\n",
      kWanted, K_coupled[0], K_coupled[2], K_diagonal[0], K_diagonal[2]);
  std::printf(
      "# work to the user per cycle into saturation with the coupled Z_q: scaled as a whole %.2g "
      "J; "
      "each actuator clamped by itself %+.3g J, %+.3g J the other way round; stored at most %.3g "
      "J\n",
      whole, clamped, -clamped, stored);
}

}  // namespace

void print_coupled_stiffness() {
  const Stylus stylus;
  for (const bool guarded : {false, true}) {
    const std::string with = guarded ? " with tank, observer" : "";
    print(compare(
        "tick stylus coupled Z_q" + with + " p50", "tick stylus diagonal Z_q" + with + " p50", "ns",
        [&] {
          return tick_p50(stylus, {true, guarded});
        },
        [&] {
          return tick_p50(stylus, {false, guarded});
        },
        0.0));
  }
  print_errors(stylus);
}

}  // namespace haptic::bench
