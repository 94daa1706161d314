#pragma once
#include <memory>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/core/model/sample_hands.hpp"

namespace haptic::test {

/// The exoskeleton with the dimensions of core/METHOD.md#finger-linkage.
inline std::shared_ptr<const core::Kinematics> one_finger() {
  static const std::shared_ptr<const core::Kinematics> kFinger =
      core::make_finger_exoskeleton(core::finger_sign_change());
  return kFinger;
}

/// Five of them, of different sizes, on a tracked palm.
inline std::shared_ptr<const core::Kinematics> hand_on_a_palm() {
  static const std::shared_ptr<const core::Kinematics> kHand =
      core::make_tracked_hand(core::five_fingers_on_a_palm());
  return kHand;
}

}  // namespace haptic::test
