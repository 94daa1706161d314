#include "finger_block.hpp"

#include <utility>

#include "haptic/core/error.hpp"

namespace haptic::core {

FingerBlock finger_block(const HandFinger& finger, const std::vector<FingerBlock>& others) {
  if (finger.name.empty()) throw SceneError("a finger's name is empty: must be given");
  for (const FingerBlock& other : others) {
    if (other.name == finger.name) {
      throw SceneError("finger " + finger.name + " given twice: names must differ");
    }
  }
  try {
    return {finger.name, make_finger_exoskeleton(finger.dimensions)};
  } catch (const SceneError& error) {
    throw SceneError("finger " + finger.name + ": " + error.what());
  }
}

void append_finger(const FingerBlock& finger, std::vector<DofSpec>& dofs) {
  for (DofSpec dof : finger.kinematics->dofs()) {
    dof.name = finger.name + "." + dof.name;
    dofs.push_back(std::move(dof));
  }
}

}  // namespace haptic::core
