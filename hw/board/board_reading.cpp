#include "hw/board/board_reading.hpp"

namespace haptic::hw::board {

void to_reading(const BoardReading& newest, const Wanted& wanted, std::uint64_t& last_seq,
                core::DeviceReading& reading) noexcept {
  reading.health = !newest.open              ? core::DeviceHealth::kLost
                   : newest.force_over_limit ? core::DeviceHealth::kForceOverLimit
                   : newest.broken           ? core::DeviceHealth::kLost
                                             : core::DeviceHealth::kOk;
  reading.armed = newest.open && wanted.arm && newest.armed == wanted.arming;
  reading.fresh = newest.open && newest.seq > last_seq;
  if (!reading.fresh) return;
  last_seq = newest.seq;
  reading.sample.seq = newest.seq;
  reading.sample.time = newest.time;
  reading.sample.q = newest.q;
  reading.sample.tau_measured = newest.force;
}

void to_wish(const hw::Command& command, Wanted& wanted) noexcept {
  if (command.arm && !wanted.arm) ++wanted.arming;
  wanted.arm = command.arm;
  if (command.tau_a.size() == wanted.tau_a.size()) {
    wanted.tau_a = command.tau_a;
  } else {
    wanted.tau_a.setZero();  // what was there may be in the board's terms already: see to_board
  }
  wanted.position = command.position;
  if (command.arm) return;
  wanted.tau_a.setZero();
  wanted.position.resize(0);
}

void to_board(const Calibration& calibration, const core::DofLayout& layout, bool closes_force_loop,
              Wanted& wanted) noexcept {
  if (wanted.position.size() > 0) {
    wanted.position = to_readings(calibration, layout, wanted.position);
  }
  if (closes_force_loop && wanted.arm) wanted.tau_a = to_force_readings(calibration, wanted.tau_a);
}

}  // namespace haptic::hw::board
