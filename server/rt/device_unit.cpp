#include "server/rt/device_unit.hpp"

#include <utility>

namespace haptic::server {

DeviceUnit::DeviceUnit(std::string name, std::unique_ptr<hw::Device> device,
                       core::PipelineConfig config)
    : settings(config.scene),
      records(kRingCapacity),
      name_(std::move(name)),
      device_(std::move(device)),
      pipeline_(std::move(config)) {
  command_.tau_a = core::VecA::Zero(pipeline_.config().kinematics->layout().n_a());
}

void DeviceUnit::tick(core::TimePoint now, core::Duration period,
                      const core::LoopReport& loop) noexcept {
  input_.now = now;
  input_.period = period;
  input_.loop = loop;
  device_->read(now, input_.device);
  if (proxies.take()) input_.proxy = proxies.value();
  if (commands.take()) input_.command = commands.value();
  settings.take();
  input_.settings = settings.value();

  const core::TickRecord record = pipeline_.tick(input_);

  command_.arm = record.arm;
  command_.tau_a = record.tau_a;
  device_->write(now, command_);
  state_ = record.state;
  records.push(record);
}

}  // namespace haptic::server
