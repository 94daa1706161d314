#include "haptic/core/model/kinematics.hpp"

#include <algorithm>

#include "haptic/core/error.hpp"

namespace haptic::core {

MapStatus Kinematics::position(const VecQ& q, VecX& x_probe) const noexcept {
  MatXQ J;
  return evaluate(q, x_probe, J);
}

std::vector<MapBlock> blocks_or_whole(const Kinematics& kinematics) {
  const std::span<const MapBlock> blocks = kinematics.blocks();
  if (blocks.empty()) return {{&kinematics, 0, 0, 0}};
  return {blocks.begin(), blocks.end()};
}

DofLayout layout_of(const std::vector<DofSpec>& dofs) {
  if (dofs.size() > static_cast<std::size_t>(kMaxQ)) {
    throw SceneError("device with " + std::to_string(dofs.size()) + " DoFs: must have at most " +
                     std::to_string(kMaxQ));
  }
  bool actuated[kMaxQ]{};
  for (std::size_t i = 0; i < dofs.size(); ++i) actuated[i] = dofs[i].actuated;
  return DofLayout(std::span<const bool>(actuated, dofs.size()));
}

}  // namespace haptic::core
