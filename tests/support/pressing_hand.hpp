#pragma once
/// A hand of equal fingers that presses: its map, and the settings of its pipeline.

#include <memory>
#include <string>
#include <vector>

#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/core/tick/pipeline.hpp"

namespace haptic {

/// Finger exoskeletons of linkage finger_sign_change (core/METHOD.md#finger-linkage), named
/// finger1, finger2, ...
inline std::shared_ptr<const core::Kinematics> equal_fingers(int count) {
  std::vector<core::HandFinger> fingers;
  for (int i = 1; i <= count; ++i)
    fingers.push_back({"finger" + std::to_string(i), core::finger_sign_change()});
  return core::make_hand_exoskeleton(fingers);
}

/// 1500 N/m and 2 N s/m per actuator, 20 N at most, 2000 N/s; limits of motion and the engage
/// window so wide that they never bear. Nothing else is on.
inline core::PipelineConfig pressing_config(const std::shared_ptr<const core::Kinematics>& map,
                                            core::RendererKind renderer) {
  const int n_a = map->layout().n_a(), n_q = map->layout().n_q();
  core::PipelineConfig config{.kinematics = map};
  config.device.q_lower = core::VecQ::Constant(n_q, -2.0);
  config.device.q_upper = core::VecQ::Constant(n_q, 2.0);
  config.device.max_effort = core::VecA::Constant(n_a, 40.0);
  config.scene.renderer = renderer;
  config.scene.stiffness = core::VecA::Constant(n_a, 1500.0);
  config.scene.damping = core::VecA::Constant(n_a, 2.0);
  config.scene.force_limit = core::VecA::Constant(n_a, 20.0);
  config.scene.slew_limit = core::VecA::Constant(n_a, 2000.0);
  config.scene.engage_window = core::VecA::Constant(n_a, 1000.0);
  return config;
}

}  // namespace haptic
