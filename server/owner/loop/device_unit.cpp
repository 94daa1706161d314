#include "server/owner/loop/device_unit.hpp"

#include <utility>

namespace haptic::server {

DeviceUnit::DeviceUnit(std::string name, std::unique_ptr<hw::Device> device,
                       core::PipelineConfig config)
    : settings(config.scene),
      records(kRingCapacity),
      name_(std::move(name)),
      device_(std::move(device)),
      pipeline_(std::move(config)) {
  input_.settings = settings.value();
  command_.tau_a = core::VecA::Zero(pipeline_.config().kinematics->layout().n_a());
}

void DeviceUnit::tick(core::TimePoint now, core::Duration period,
                      const core::LoopReport& loop) noexcept {
  input_.now = now;
  input_.period = period;
  input_.loop = loop;

  input_.device.fresh = false;
  device_->read(now, input_.device);

  if (poses.take()) input_.tracker = poses.value();
  if (commands.take()) input_.command = commands.value();
  if (settings.take()) input_.settings = settings.value();

  proxies.take();
  const core::TickRecord& record =
      records.prepare([this] { return pipeline_.tick(input_, proxies.value()); });

  command_.arm = record.life.arm;
  command_.tau_a = record.effort.drive.size() > 0 ? record.effort.drive : record.effort.tau_a;
  command_.position = record.effort.position;
  device_->write(now, command_);

  records.push();
  state_.store(record.life.state, std::memory_order_release);
}

namespace {

/// Ticks of a rehearsal: IDLE, ARMED, a healthy stream of 200 ms, ENGAGING to ENGAGED and out
/// again.
constexpr int kRehearsalTicks = 800;
constexpr int kEngageAt = 300;
constexpr int kReleaseAt = 650;

/// A device in the middle of its range and a proxy at its probe, in the way once it is held: every
/// stage has work.
core::TickInput resting(const core::PipelineConfig& config, core::ProxySnapshot& proxy) {
  core::TickInput input;
  input.settings = config.scene;
  input.device.armed = true;
  input.device.sample.q = 0.5 * (config.device.q_lower + config.device.q_upper);
  core::MatXQ J;
  const auto status = config.kinematics->evaluate(input.device.sample.q, proxy.x, J);
  if (status != core::MapStatus::kOk) proxy.x.setZero(config.kinematics->space().n_x());
  proxy.mode = core::ProxyMode::kFree;
  proxy.tenure = 1;
  if (config.tracker) {
    for (std::size_t i = 0; i < core::kPalmDofs; ++i) {
      const Eigen::Index dof = config.tracker->first_dof + static_cast<Eigen::Index>(i);
      input.tracker.pose[i] = input.device.sample.q[dof];
    }
    input.tracker.staleness = config.tracker->staleness;
  }
  return input;
}

}  // namespace

void DeviceUnit::rehearse() const {
  using namespace std::chrono_literals;
  core::Pipeline understudy(config());
  core::ProxySnapshot proxy;
  core::TickInput input = resting(config(), proxy);
  input.now = core::TimePoint(1h);
  proxy.gapless_since = input.now;
  input.command.tenure = 1;
  input.command.lease_held = true;
  for (int i = 1; i <= kRehearsalTicks; ++i) {
    input.now += input.period;
    if (i > 1) proxy.mode = core::ProxyMode::kHeld;  // free first: force would not start else
    input.device.fresh = true;
    input.device.sample.seq++;
    input.device.sample.time = input.now;
    proxy.seq++;
    proxy.born = input.now;
    proxy.gapless_samples++;
    input.tracker.seq++;
    input.tracker.born = input.now;
    input.command.engage_id = i >= kEngageAt ? 1 : 0;
    input.command.release_id = i >= kReleaseAt ? 1 : 0;
    static_cast<void>(understudy.tick(input, proxy));
  }
}

}  // namespace haptic::server
