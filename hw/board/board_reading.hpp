#pragma once
/// From what the board's host has to what the loop reads, and back. Pure.

#include "haptic/core/tick/tick_input.hpp"
#include "hw/board/board_host.hpp"
#include "hw/board/calibration.hpp"
#include "hw/device.hpp"

namespace haptic::hw::board {

/// The loop's view of `newest`. `wanted`: what the loop asked for last; the board counts as armed
/// only under that very arming. `last_seq`: of the newest sample delivered, moved on with this one.
void to_reading(const BoardReading& newest, const Wanted& wanted, std::uint64_t& last_seq,
                core::DeviceReading& reading) noexcept;

/// The loop's newest command as a wish: every new arming has a number of its own, and what is not
/// armed gets neither force nor position.
void to_wish(const hw::Command& command, Wanted& wanted) noexcept;

/// The same wish to a board whose sensors mean something else than they read: positions for its
/// servo, and, where it closes the loop on the force itself, forces, as its own sensors will read
/// them.
void to_board(const Calibration& calibration, const core::DofLayout& layout, bool closes_force_loop,
              Wanted& wanted) noexcept;

}  // namespace haptic::hw::board
