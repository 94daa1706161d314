#pragma once
/// A finger of a hand: its own map, and its DoFs under its name.

#include <memory>
#include <string>
#include <vector>

#include "haptic/core/model/hand_exoskeleton.hpp"

namespace haptic::core {

struct FingerBlock {
  std::string name{};
  std::shared_ptr<const Kinematics> kinematics{};
};

/// Throws SceneError naming the finger: a name empty or among `others`, dimensions that cannot be.
[[nodiscard]] FingerBlock finger_block(const HandFinger& finger,
                                       const std::vector<FingerBlock>& others);
/// NAME.l_x and NAME.q_B.
void append_finger(const FingerBlock& finger, std::vector<DofSpec>& dofs);

}  // namespace haptic::core
