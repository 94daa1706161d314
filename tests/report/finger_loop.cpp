#include "tests/report/finger_loop.hpp"
#include "tests/report/chosen_linkage.hpp"

#include <algorithm>
#include <cmath>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/motion/minimum_jerk.hpp"
#include "hw/simulated/finger_physics.hpp"
#include "tests/report/finger_press.hpp"
#include "tests/support/loop/pipeline_loop.hpp"

namespace haptic::report {
namespace {

using core::VecQ;
using core::VecX;

constexpr double kEngage_s = 0.6;  // ten samples at 30 Hz, 100 ms late, and some
constexpr double kLeave_s = 0.9;   // the gain's ramp is over
constexpr double kBegin_s = 1.8;   // the way takes 0.8 s as in core/METHOD.md#forces-at-the-finger
// tests/report/STUDY.md#chosen-presses-finger_sign_change: end state after 1.5-2 s, from its
// beginning.
constexpr double kPress_s = 2.0;

core::PipelineConfig pipeline_for(const FingerLoop& what,
                                  std::shared_ptr<const core::Kinematics> finger) {
  core::PipelineConfig config = finger_pipeline(std::move(finger), what.method, what.stiffness);
  config.scene.direction_guard = what.with != Safeguard::kNothing;
  config.passivity.tank.enabled = what.with == Safeguard::kGuardTank;
  config.passivity.tank.initial = what.tank_initial;
  // The ladder of proto/README.md#staleness-and-gain has its own tests; here a slow client is still
  // a client.
  config.scene.staleness.hold_end = std::chrono::milliseconds(400);
  config.scene.staleness.fade_end = std::chrono::milliseconds(500);
  return config;
}

Eigen::Vector2d degrees(double mcp, double pip) {
  return Eigen::Vector2d(mcp, pip) * kDegree;
}

/// Where the finger is led or the hand aims, in joint angles, at `t` s.
class Path {
 public:
  Path(const FingerLoop& what, const core::Kinematics& finger)
      : what_(what), finger_(finger), q_centre_(VecQ::Zero(2)) {
    const Eigen::Vector2d centre = degrees(30, 30);  // core/METHOD.md#results
    static_cast<void>(finger.inverse(VecX(centre), q_centre_));
  }
  [[nodiscard]] static Eigen::Vector2d ease() { return degrees(5, 5); }
  [[nodiscard]] Eigen::Vector2d at(double t) const {
    const double way = hw::minimum_jerk((t - kLeave_s) / (kBegin_s - 0.1 - kLeave_s));
    return way < 1.0 ? Eigen::Vector2d(ease() + way * (motion(0.0) - ease()))
                     : motion(std::max(t - kBegin_s, 0.0));
  }

 private:
  [[nodiscard]] Eigen::Vector2d motion(double t) const {
    const double phase = 2.0 * M_PI * t, sign = what_.reversed ? -1.0 : 1.0;
    if (what_.motion == Motion::kPress) return degrees(50, 50);
    if (what_.motion == Motion::kHand) {
      return degrees(35 + 15 * std::cos(phase), 35 + sign * 15 * std::sin(phase));
    }
    VecQ q = q_centre_;
    q[0] += 0.002 * std::cos(phase);
    q[1] += sign * 0.05 * std::sin(phase);
    VecX x = VecX::Zero(2);
    core::MatXQ J = core::MatXQ::Zero(2, 2);
    static_cast<void>(finger_.evaluate(q, x, J));
    return {x[0], x[1]};
  }
  const FingerLoop& what_;
  const core::Kinematics& finger_;
  VecQ q_centre_;
};

/// The device: led along the path, or worn by a finger whose hand aims along it.
class Device {
 public:
  Device(const FingerLoop& what, const std::shared_ptr<const core::Kinematics>& finger)
      : finger_(finger),
        path_(what, *finger_),
        led_(what.motion == Motion::kCycle),
        physics_({}, finger, Path::ease()) {}
  /// q at t, the force tau held since one tick before.
  [[nodiscard]] VecQ advance(double t, double tau) {
    if (led_) {
      VecQ q = VecQ::Zero(2);
      static_cast<void>(finger_->inverse(VecX(path_.at(t)), q));
      return q;
    }
    step_tick(
        physics_, t, [this](double at) { return path_.at(at); }, tau);
    return physics_.q();
  }

 private:
  std::shared_ptr<const core::Kinematics> finger_;
  Path path_;
  bool led_;
  hw::FingerPhysics physics_;
};

void account(const FingerLoop& what, const core::TickRecord& record, LoopFigures& figures) {
  const double d = record.effort.q_star[0] - record.sensed.q[0];
  const double force = std::abs(record.effort.tau_a[0]);
  const double stored = 0.5 * record.input.settings.stiffness[0] * d * d;
  figures.peak_storage = std::max(figures.peak_storage, stored);
  figures.mean_force += force;
  figures.peak_force = std::max(figures.peak_force, force);
  for (int i = 0; i < 2; ++i) {
    figures.max_penetration_deg = std::max(
        figures.max_penetration_deg, (record.anchor.x_probe[i] - what.client.stop[i]) / kDegree);
  }
  figures.withheld += record.limiters().has(core::Limiter::kDirectionGuard) ? 1 : 0;
  ++figures.ticks;
}

}  // namespace

LoopFigures run(const FingerLoop& what, const std::function<void(const LoopTick&)>& observe) {
  const std::shared_ptr<const core::Kinematics> finger =
      core::make_finger_exoskeleton(chosen_linkage());
  Device device(what, finger);
  test::PipelineLoop loop(pipeline_for(what, finger), what.client, kFingerDamping);
  const bool press = what.motion == Motion::kPress;
  const auto tick_of = [](double t) { return static_cast<int>(std::lround(t * 1000.0)); };
  const int judged = tick_of(press ? kLeave_s : kBegin_s + kCycles - 1.0);
  const int last = tick_of(press ? kLeave_s + kPress_s : kBegin_s + kCycles);
  LoopFigures figures;
  for (int k = 1; k <= last; ++k) {
    if (k == tick_of(kEngage_s)) loop.engage();
    const core::TickRecord& record =
        loop.tick(device.advance(k * test::PipelineLoop::kTick_s, loop.tau()));
    if (k == judged) loop.energy().begin_cycle();
    figures.throttled += record.limiters().has(core::Limiter::kEnergyTank) ? 1 : 0;
    if (k > judged) account(what, record, figures);
    if (observe) {
      observe({loop.time_s() - kBegin_s,
               {loop.x_probe()[0] / kDegree, loop.x_probe()[1] / kDegree},
               record.effort.tau_a[0],
               loop.energy().given_in_all(),
               loop.energy().net_in_all()});
    }
  }
  loop.require_engaged();
  figures.given = loop.energy().given();
  figures.net = loop.energy().net();
  figures.most_net = loop.energy().most_net();
  figures.mean_force /= std::max(figures.ticks, 1);
  return figures;
}

}  // namespace haptic::report
