#pragma once
/// An emulated board in real time at the end of a pseudo-terminal.

#include <atomic>
#include <functional>

#include "hw/emulator/emulated_board.hpp"
#include "hw/emulator/pseudo_terminal.hpp"

namespace haptic::hw::emulator {

/// Called after every millisecond of the board's time that was caught up with; may move the hand.
using Watcher = std::function<void(EmulatedBoard& board)>;

/// Runs until `stop` or, where `seconds` > 0, for so long. Of a pause of this process (suspend,
/// debugger) the board sees 100 ms at most. Unplugs and plugs the terminal as the board's faults
/// demand.
void serve(EmulatedBoard& board, PseudoTerminal& terminal, const std::atomic<bool>& stop,
           double seconds = 0.0, const Watcher& watcher = {});

}  // namespace haptic::hw::emulator
