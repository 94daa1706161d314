#pragma once
#include <memory>

#include "haptic/core/model/finger_exoskeleton.hpp"

namespace haptic::test {

/// The exoskeleton with the dimensions of core/METHOD.md#finger-linkage.
inline std::shared_ptr<const core::Kinematics> one_finger() {
  static const std::shared_ptr<const core::Kinematics> kFinger =
      core::make_finger_exoskeleton(core::finger_sign_change());
  return kFinger;
}

}  // namespace haptic::test
