#pragma once
/// The linkage of which a subcommand makes its figures: --linkage of haptic-report.

#include <string>

#include "haptic/core/model/finger_exoskeleton.hpp"

namespace haptic::report {

/// finger_same_sign, the default of FingerDimensions, until main() reads another name.
inline core::FingerDimensions& chosen_linkage() {
  static core::FingerDimensions dimensions;
  return dimensions;
}

[[nodiscard]] inline std::string chosen_linkage_name() {
  return chosen_linkage().rail_angle == core::FingerDimensions{}.rail_angle ? "finger_same_sign"
                                                                            : "finger_sign_change";
}

}  // namespace haptic::report
