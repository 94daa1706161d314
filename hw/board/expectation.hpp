#pragma once
/// Requirements of the scene to a board, and how a board differs from them. A board that differs is
/// never armed.

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/time.hpp"
#include "haptic/core/types.hpp"
#include "hw/board/messages.hpp"

namespace haptic::hw::board {

/// The longest watchdog of a board: for so long it may keep its last force without a host.
inline constexpr core::Duration kLongestWatchdog{std::chrono::seconds(1)};

struct Expectation {
  std::vector<core::DofSpec> dofs{};
  core::VecA max_effort{};  ///< n_a: the dictionary must allow at least this much
  /// loop_late_fault; the board's watchdog must be longer, up to kLongestWatchdog.
  core::Duration longest_lateness{0};
  std::string serial{};   ///< empty: any board
  std::string linkage{};  ///< one of kFingerLinkages that the scene has as it is; empty: none
};

/// How `found` differs, as the end of a sentence about the board; empty if it fits. `before`: the
/// board that was at this port before it was unplugged. Its serial number, model, capabilities and
/// sample period must be the same, because the loop was built with them.
[[nodiscard]] std::string difference(const Expectation& expected, const Identity& found,
                                     const std::optional<Identity>& before);

/// The linkage could not be compared, as the end of a sentence about a board that fits: the scene
/// has one with a name, and the board's model is no such name. Empty if there is nothing to say.
[[nodiscard]] std::string not_compared(const Expectation& expected, const Identity& found);

/// The same for entry number `index` of the dictionary, below expected.dofs.size().
[[nodiscard]] std::string difference(const Expectation& expected, std::size_t index,
                                     const Dof& found);

/// The same for the number of forces that a board takes and measures, once its dictionary fits.
[[nodiscard]] std::string difference_of_actuators(const Expectation& expected,
                                                  const Identity& found);

}  // namespace haptic::hw::board
