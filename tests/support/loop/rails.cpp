#include "tests/support/loop/rails.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "haptic/core/model/linear.hpp"

namespace haptic::test {
namespace {

constexpr int kHandSteps = 10;
constexpr double kHandStep = 1e-3 / kHandSteps;  // s
constexpr double kBefore = -1.0;                 // s

}  // namespace

void swing(double t, double hz, double centre, double amplitude, Eigen::Index i, HandAim& aim) {
  const double w = 2.0 * M_PI * hz, phase = w * std::max(t, 0.0);
  aim.at[i] = centre - amplitude * std::cos(phase);
  aim.rate[i] = t > 0.0 ? amplitude * w * std::sin(phase) : 0.0;
}

Hand swinging(double hz, double amplitude) {
  return [=](double t) {
    HandAim aim{core::VecQ(1), core::VecQ(1)};
    swing(t, hz, 0.0, amplitude, 0, aim);
    return aim;
  };
}

HandMasses::HandMasses(Hand hand, const HandOnMass& of)
    : hand_(std::move(hand)), of_(of), q_(hand_(kBefore).at), v_(core::VecQ::Zero(q_.size())) {}

void HandMasses::step(double t, const core::VecA& tau) {
  for (int s = kHandSteps - 1; s >= 0; --s) {
    const HandAim aim = hand_(t - s * kHandStep);
    const core::VecQ push = of_.hand * (aim.at - q_) + of_.hand_damping * (aim.rate - v_) + tau;
    v_ = (v_ + kHandStep * push / of_.mass) / (1.0 + kHandStep * of_.damping / of_.mass);
    q_ += kHandStep * v_;
  }
}

core::PipelineConfig rails(int n) {
  core::LinearMap map{.A = core::MatXQ::Identity(n, n), .x_0 = core::VecX::Zero(n)};
  for (int i = 0; i < n; ++i) {
    const std::string number = std::to_string(i + 1);
    map.dofs.push_back({"l" + number, core::Unit::kMetre, true, -0.2, 0.2});
    map.coordinates.push_back({"x" + number, core::Unit::kMetre, core::CoordinateKind::kLinear});
  }
  core::PipelineConfig c{.kinematics = core::make_linear(map)};
  c.device.q_lower = core::VecQ::Constant(n, -1.0);
  c.device.q_upper = core::VecQ::Constant(n, 1.0);
  c.device.max_effort = core::VecA::Constant(n, 100.0);
  c.scene.stiffness = core::VecA::Constant(n, Rails::coupling);
  c.scene.damping = core::VecA::Zero(n);
  c.scene.force_limit = core::VecA::Constant(n, 60.0);
  c.scene.slew_limit = core::VecA::Constant(n, 1e7);
  c.scene.engage_window = core::VecA::Constant(n, 60.0);
  c.passivity.device_damping = core::VecA::Constant(n, Rails::damping);
  c.passivity.device_inertia = c.passivity.observer.inertia = core::VecA::Constant(n, Rails::mass);
  return c;
}

core::PipelineConfig patient_rail(double tank) {
  core::PipelineConfig c = rails(1);
  c.scene.staleness.hold_end = std::chrono::milliseconds(400);
  c.scene.staleness.fade_end = std::chrono::milliseconds(500);
  c.passivity.tank.enabled = tank >= 0.0;
  if (tank >= 0.0) c.passivity.tank.initial = tank;
  return c;
}

}  // namespace haptic::test
