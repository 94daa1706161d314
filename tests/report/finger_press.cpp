#include "tests/report/finger_press.hpp"
#include "tests/report/chosen_linkage.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/device_limits.hpp"
#include "hw/simulated/hand.hpp"
#include "tests/report/best_force.hpp"
#include "tests/support/virtual_board.hpp"

namespace haptic::report {
namespace {

using core::VecA;
using core::VecX;
using hw::emulator::VirtualBoard;

// tests/report/STUDY.md#chosen-presses-finger_sign_change: end state after 1.5-2 s.
constexpr double kPeriod = 1e-3;  // s
constexpr int kTicks = 2000;
constexpr int kEngageTick = 205;  // a steady stream of 200 ms is asked for; the hand barely moved
constexpr double kRodDamping = 0.5;  // N s/m, beyond the load cell of the emulated board

core::PipelineConfig pipeline_for(const Press& what, const hw::Device& device,
                                  std::shared_ptr<const core::Kinematics> finger) {
  core::PipelineConfig config = finger_pipeline(std::move(finger), what.method, what.stiffness);
  config.device = device.info().limits;
  config.scene.direction_guard = what.direction_guard;
  config.passivity.tank.enabled = what.energy_tank;
  return config;
}

std::unique_ptr<hw::Device> worn_device(const Press& what,
                                        const std::shared_ptr<const core::Kinematics>& finger) {
  if (what.board) {
    hw::BoardConfig config;
    config.max_effort = VecA::Constant(1, kFingerForceLimit);
    const Eigen::Vector2d target(what.target_deg.first * kDegree, what.target_deg.second * kDegree);
    return std::make_unique<VirtualBoard>(hw::emulator::EmulatorConfig{},
                                          hw::HandIntent(Eigen::Vector2d::Zero(), target), config,
                                          finger);
  }
  hw::SimulatedHandConfig hand;
  hand.target = kDegree * Eigen::Vector2d(what.target_deg.first, what.target_deg.second);
  return hand.open(finger, {});
}

/// The newest sample of a client without delay: the pose clipped at the stops, free at first.
void publish(core::TimePoint now, const VecX& x, core::ProxySnapshot& proxy) {
  proxy.mode = ++proxy.seq == 1 ? core::ProxyMode::kFree : core::ProxyMode::kHeld;
  proxy.tenure = 1;
  proxy.born = now;
  if (proxy.seq == 1) proxy.gapless_since = now;
  ++proxy.gapless_samples;
  proxy.x = x;
}

PressTick felt_at(double t_s, const VecX& x, const core::MatXQ& J, double tau_a, double cell) {
  const VecX w = lever(J);
  return {t_s, {x[0] / kDegree, x[1] / kDegree}, tau_a, cell, {w[0] * cell, w[1] * cell}};
}

/// The force that really acts on the linkage, and where the finger really is: behind a board
/// neither is what was commanded nor what was measured.
PressTick felt_through(const VirtualBoard& device, const core::Kinematics& finger, double t_s,
                       double tau_a) {
  const hw::emulator::Rig& rig = device.board().rig();
  VecX x;
  core::MatXQ J;
  if (finger.evaluate(rig.finger().q(), x, J) != core::MapStatus::kOk) {
    throw core::SceneError("finger: the finger at the board left the linkage's range");
  }
  return felt_at(t_s, x, J, tau_a, rig.actuator().force());
}

/// The one of larger magnitude, with its sign.
void keep_peak(double& peak, double value) {
  if (std::abs(value) > std::abs(peak)) peak = value;
}

void account(const Press& what, const PressTick& tick, Felt& felt) {
  felt.end = tick;
  felt.max_penetration_deg =
      std::max({felt.max_penetration_deg, tick.x_deg.first - what.stop_deg.first,
                tick.x_deg.second - what.stop_deg.second});
  keep_peak(felt.peak_force, tick.tau_a);
  keep_peak(felt.peak_cell, tick.cell);
  keep_peak(felt.peak_tau_x.first, tick.tau_x.first);
  keep_peak(felt.peak_tau_x.second, tick.tau_x.second);
}

}  // namespace

core::PipelineConfig finger_pipeline(std::shared_ptr<const core::Kinematics> finger,
                                     core::RendererKind method, double stiffness) {
  constexpr double kMeanOnA = 81.06;  // rad/m
  const bool baseline =
      method == core::RendererKind::kStandard || method == core::RendererKind::kNullSpace;
  if (baseline) stiffness *= std::pow(finger->mean_actuated_jacobian() / kMeanOnA, 2);
  core::PipelineConfig config;
  config.device = hw::device_limits(*finger, VecA::Constant(1, kFingerForceLimit));
  config.passivity.device_damping = VecA::Constant(1, kFingerDamping);
  config.scene.renderer = method;
  config.scene.stiffness = VecA::Constant(1, stiffness);
  config.scene.damping = VecA::Zero(1);
  config.scene.force_limit = VecA::Constant(1, kFingerForceLimit);
  config.scene.slew_limit = VecA::Constant(1, 1e6);  // N/s: none
  config.scene.engage_window = VecA::Constant(1, kFingerForceLimit);
  config.kinematics = std::move(finger);
  return config;
}

Felt press(const Press& what, const std::function<void(const PressTick&)>& observe) {
  const std::shared_ptr<const core::Kinematics> finger =
      core::make_finger_exoskeleton(chosen_linkage());
  const auto device = worn_device(what, finger);
  const auto* board = dynamic_cast<const VirtualBoard*>(device.get());
  core::Pipeline pipeline(pipeline_for(what, *device, finger));
  const VecX stop =
      (VecX(2) << what.stop_deg.first * kDegree, what.stop_deg.second * kDegree).finished();

  core::ProxySnapshot newest;
  core::TickInput input;
  input.settings = pipeline.config().scene;
  input.command.tenure = 1;
  input.command.lease_held = true;
  hw::Command command{true, VecA::Zero(1)};
  Felt felt;
  core::VecQ last_q;
  double last_cell = 0.0;
  const double own_damping = board == nullptr ? kFingerDamping : kRodDamping;
  core::LifecycleState state{};
  VecX x_probe = VecX::Zero(2);
  core::MatXQ J;
  for (int k = 1; k <= kTicks; ++k) {
    input.now = core::TimePoint(std::chrono::milliseconds(k));
    device->read(input.now, input.device);
    if (input.device.sample.q.size() == 0) continue;  // a board's first sample is on its way
    const core::VecQ q = input.device.sample.q;
    const core::VecQ where = board == nullptr ? q : board->board().rig().finger().q();
    if (finger->evaluate(q, x_probe, J) != core::MapStatus::kOk) {
      throw core::SceneError("finger: the simulated finger left the linkage's range");
    }
    if (last_q.size() == 2) {
      // The force of the last tick was held over the way from its pose to this one.
      const double way = where[0] - last_q[0];
      const double held = board == nullptr ? command.tau_a[0] : last_cell;
      felt.work += held * way;
      felt.net_work += held * way - own_damping * way * way / kPeriod;
    }
    last_q = where;
    publish(input.now, x_probe.cwiseMin(stop), newest);
    if (what.force && k >= kEngageTick && state == core::LifecycleState::kArmed) {
      ++input.command.engage_id;
    }
    const core::TickRecord record = pipeline.tick(input, newest);
    state = record.life.state;
    felt.withheld += record.limiters().has(core::Limiter::kDirectionGuard) ? 1 : 0;
    felt.throttled += record.limiters().has(core::Limiter::kEnergyTank) ? 1 : 0;
    command = {record.life.arm, record.effort.tau_a, {}};
    device->write(input.now, command);
    const PressTick tick =
        board != nullptr
            ? felt_through(*board, *finger, kPeriod * k, record.effort.tau_a[0])
            : felt_at(kPeriod * k, x_probe, J, record.effort.tau_a[0], record.effort.tau_a[0]);
    last_cell = tick.cell;
    account(what, tick, felt);
    if (observe) observe(tick);
  }
  if (what.force && state != core::LifecycleState::kEngaged) {
    throw core::SceneError("finger: the device ended in state " + std::string(core::name(state)) +
                           ", not ENGAGED: there was no force to judge");
  }
  return felt;
}

}  // namespace haptic::report
