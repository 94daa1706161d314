#include "hw/board/board_device.hpp"

#include <sstream>

#include "haptic/core/error.hpp"
#include "hw/board/board_io.hpp"
#include "hw/device_limits.hpp"
#include "hw/open_device.hpp"

namespace haptic::hw {
namespace {

constexpr core::Duration kPatience = std::chrono::seconds(3);

board::Expectation expectation(const BoardConfig& config, const core::Kinematics& kinematics) {
  board::Expectation expected;
  expected.dofs = kinematics.dofs();
  expected.max_effort = config.max_effort;
  expected.longest_lateness = config.longest_lateness;
  expected.serial = config.serial;
  return expected;
}

std::string describe(const board::Identity& identity, const std::string& port) {
  std::ostringstream text;
  text << identity.model << ", firmware " << static_cast<int>(identity.firmware[0]) << '.'
       << static_cast<int>(identity.firmware[1]) << '.' << static_cast<int>(identity.firmware[2])
       << ", at " << port;
  return text.str();
}

}  // namespace

BoardDevice::BoardDevice(const BoardConfig& config,
                         const std::shared_ptr<const core::Kinematics>& kinematics) {
  info_.kind = "board";
  info_.dofs = kinematics->dofs();
  info_.limits = device_limits(*kinematics, config.max_effort);
  info_.limits.max_silence = config.max_silence;
  io_ = std::make_unique<Io>(config.port, config.baud, expectation(config, *kinematics));
  const board::Identity identity = io_->greeted(kPatience);
  info_.model = describe(identity, config.port);
  info_.serial = identity.serial;
  info_.limits.sample_period = std::chrono::microseconds(identity.sample_period_us);
  info_.notes = io_->notes();
  wanted_.tau_a = core::VecA::Zero(config.max_effort.size());
}

BoardDevice::~BoardDevice() {
  close();
}

void BoardDevice::close() noexcept {
  io_->stop();
}

board::HostCounters BoardDevice::counters() const {
  return io_->counters();
}

void BoardDevice::read(core::TimePoint, core::DeviceReading& reading) noexcept {
  static_cast<void>(io_->readings.take());
  const board::BoardReading& newest = io_->readings.value();
  reading.health = !newest.open              ? core::DeviceHealth::kLost
                   : newest.force_over_limit ? core::DeviceHealth::kForceOverLimit
                   : newest.broken           ? core::DeviceHealth::kLost
                                             : core::DeviceHealth::kOk;
  reading.armed = newest.open && wanted_.arm && newest.armed == wanted_.arming;
  reading.fresh = newest.open && newest.seq > last_seq_;
  if (!reading.fresh) return;
  last_seq_ = newest.seq;
  reading.sample.seq = newest.seq;
  reading.sample.time = newest.time;
  reading.sample.q = newest.q;
  reading.sample.tau_measured = newest.force;
}

void BoardDevice::write(core::TimePoint, const Command& command) noexcept {
  if (command.arm && !wanted_.arm) ++wanted_.arming;
  wanted_.arm = command.arm;
  if (command.tau_a.size() == wanted_.tau_a.size()) wanted_.tau_a = command.tau_a;
  if (!command.arm) wanted_.tau_a.setZero();
  io_->want(wanted_);
}

}  // namespace haptic::hw
