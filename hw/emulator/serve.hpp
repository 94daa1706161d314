#pragma once
/// An emulated board in real time at the end of a pseudo-terminal.

#include <atomic>
#include <functional>

#include "hw/emulator/emulated_board.hpp"
#include "hw/emulator/pseudo_terminal.hpp"

namespace haptic::hw::emulator {

/// Called once per millisecond of the board's time; may move the hand.
using Watcher = std::function<void(EmulatedBoard& board)>;

/// Runs until `stop`. If this process pauses (suspend, debugger), the board sees at most 100 ms of
/// the pause. Unplugs and plugs the terminal as the board's faults demand.
void serve(EmulatedBoard& board, PseudoTerminal& terminal, const std::atomic<bool>& stop,
           const Watcher& watcher = {});

}  // namespace haptic::hw::emulator
