#pragma once
/// Averages over the box of a map, at the same points every time (Halton), so that a scene loads
/// equally everywhere. For set-up only.

#include "haptic/core/model/kinematics.hpp"

namespace haptic::core {

/// The i-th point of the Halton sequence (i >= 0) in the box of q. n_q values, m or rad.
[[nodiscard]] VecQ workspace_sample(const Kinematics& kinematics, int i);

/// Mean of ||J_a|| (Frobenius) over the box; 0 if f has no value at any sample.
[[nodiscard]] double mean_actuated_jacobian(const Kinematics& kinematics);

}  // namespace haptic::core
