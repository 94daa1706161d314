#include "hw/board/device_side.hpp"

#include <sstream>
#include <utility>

#include "hw/board/board_device.hpp"
#include "hw/device_limits.hpp"

namespace haptic::hw::board {

DeviceSide::DeviceSide(const BoardConfig& config,
                       std::shared_ptr<const core::Kinematics> kinematics,
                       core::Duration longest_lateness)
    : kinematics_(std::move(kinematics)),
      calibration_(config.calibration),
      expectation_{kinematics_->dofs(), config.max_effort, longest_lateness, config.serial,
                   config.linkage} {
  info_.kind = "board";
  info_.dofs = kinematics_->dofs();
  info_.limits = device_limits(*kinematics_, config.max_effort);
  info_.limits.max_silence = config.max_silence;
  wanted_.tau_a = core::VecA::Zero(config.max_effort.size());
}

void DeviceSide::identify(const Introduction& said) {
  const Identity& identity = said.identity;
  std::ostringstream model;
  model << identity.model << ", firmware " << int{identity.firmware[0]} << '.'
        << int{identity.firmware[1]} << '.' << int{identity.firmware[2]};
  info_.model = model.str();
  info_.serial = identity.serial;
  if (const std::string unknown = not_compared(expectation_, identity); !unknown.empty()) {
    info_.notes.push_back("the board " + unknown);
  }
  info_.limits.drive_damping = said.drive_damping;
  info_.limits.sample_period = std::chrono::microseconds(identity.sample_period_us);
  info_.measures_force = (identity.capabilities & HB_MEASURES_FORCE) != 0;
  info_.closes_force_loop = (identity.capabilities & HB_FORCE_LOOP) != 0;
  info_.takes_positions = (identity.capabilities & HB_POSITION_COMMAND) != 0;
  if (!calibration_) return;
  check(*calibration_, *kinematics_, info_.serial, info_.measures_force);
  apply(*calibration_, info_.limits);
  info_.calibrated = calibration_->date;
}

void DeviceSide::read(const BoardReading& newest, core::DeviceReading& reading) noexcept {
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
  if (calibration_) apply(*calibration_, reading.sample);
}

const Wanted& DeviceSide::write(const hw::Command& command) noexcept {
  if (command.arm && !wanted_.arm) ++wanted_.arming;
  wanted_.arm = command.arm;
  wanted_.position.resize(0);
  wanted_.tau_a.setZero();
  if (!command.arm) return wanted_;
  wanted_.position = command.position;
  if (command.tau_a.size() == wanted_.tau_a.size()) wanted_.tau_a = command.tau_a;
  if (!calibration_) return wanted_;
  if (command.position.size() > 0) {
    wanted_.position = to_readings(*calibration_, kinematics_->layout(), command.position);
  }
  if (info_.closes_force_loop) wanted_.tau_a = to_force_readings(*calibration_, wanted_.tau_a);
  return wanted_;
}

}  // namespace haptic::hw::board
