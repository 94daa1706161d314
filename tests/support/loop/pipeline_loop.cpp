#include "tests/support/loop/pipeline_loop.hpp"

#include <algorithm>
#include <string>

#include "haptic/core/error.hpp"

namespace haptic::test {

void EnergyBook::add(const core::VecA& tau_held, const core::VecA& way, double dt) noexcept {
  const double work = tau_held.dot(way);
  given_ += work;
  net_ += work - damping_ * way.squaredNorm() / dt;
  most_given_ = std::max(most_given_, given_);
  most_net_ = std::max(most_net_, net_);
}

void EnergyBook::begin_cycle() noexcept {
  given_before_ = given_;
  net_before_ = net_;
}

PipelineLoop::PipelineLoop(const core::PipelineConfig& config, const ClientSettings& client,
                           double device_damping)
    : pipeline_(config), client_(client, config.filter.longest_s() > 0.0), energy_(device_damping) {
  const core::Kinematics& map = *config.kinematics;
  input_.settings = config.scene;
  input_.device.fresh = input_.device.armed = true;
  input_.command.tenure = 1;
  input_.command.lease_held = true;
  x_probe_ = core::VecX::Zero(map.space().n_x());
  tau_ = last_q_a_ = core::VecA::Zero(map.layout().n_a());
  J_ = core::MatXQ::Zero(map.space().n_x(), map.layout().n_q());
}

const core::TickRecord& PipelineLoop::tick(const core::VecQ& q) {
  const core::Kinematics& map = *pipeline_.config().kinematics;
  const core::VecA q_a = map.layout().select(q);
  if (ticks_ > 0) energy_.add(tau_, q_a - last_q_a_, kTick_s);
  last_q_a_ = q_a;
  if (map.evaluate(q, x_probe_, J_) != core::MapStatus::kOk) {
    throw core::SceneError("loop: the device left the linkage's range");
  }
  ++ticks_;
  input_.now = core::TimePoint(std::chrono::milliseconds(ticks_));
  input_.device.sample.seq = static_cast<std::uint64_t>(ticks_);
  input_.device.sample.time = input_.now;
  input_.device.sample.q = q;
  client_.step(time_s(), input_.now, q, x_probe_, proxy_);
  if (ticks_ == 1 && proxy_.mode != core::ProxyMode::kPlanes) {
    proxy_.mode = core::ProxyMode::kFree;  // the probe comes from outside
    proxy_.tenure = input_.command.tenure;
  }
  record_ = pipeline_.tick(input_, proxy_);
  client_.look_after(time_s(), record_.sensed.q, record_.anchor.x_probe);
  tau_ = record_.effort.tau_a;
  return record_;
}

void PipelineLoop::require_engaged() const {
  if (record_.life.state == core::LifecycleState::kEngaged) return;
  throw core::SceneError("loop: the device is in state " +
                         std::string(core::name(record_.life.state)) +
                         ", not ENGAGED: there is no force to judge");
}

}  // namespace haptic::test
