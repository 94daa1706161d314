#include "haptic/core/model/dof_layout.hpp"

#include <string>

#include "haptic/core/error.hpp"

namespace haptic::core {

DofLayout::DofLayout(std::span<const bool> actuated) : n_q_(static_cast<int>(actuated.size())) {
  if (actuated.empty() || actuated.size() > static_cast<std::size_t>(kMaxQ)) {
    throw SceneError("device with " + std::to_string(actuated.size()) + " DoFs: must have 1 to " +
                     std::to_string(kMaxQ));
  }
  int n_n = 0;
  for (int i = 0; i < n_q_; ++i) {
    if (actuated[static_cast<std::size_t>(i)]) {
      actuated_[n_a_++] = i;
    } else {
      sensed_[n_n++] = i;
    }
  }
  if (n_a_ == 0) throw SceneError("device without an actuated DoF: must have at least one");
}

VecA DofLayout::select(const VecQ& q) const noexcept {
  VecA q_a(n_a_);
  for (int i = 0; i < n_a_; ++i) q_a[i] = q[actuated_[i]];
  return q_a;
}

}  // namespace haptic::core
