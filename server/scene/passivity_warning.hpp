#pragma once
/// Springs that a simulated device cannot be given without creating energy.

#include <string>
#include <vector>

#include "server/scene/scene.hpp"

namespace haptic::server {

/// One sentence per actuated DoF of a simulated device whose stiffness is above
/// 2 (b - B) / T: b the device's own damping, B the rendered one, T the loop's
/// period. Source: Colgate and Schenkel, b > K T / 2 + |B|; core/METHOD.md#sampled-data. Nothing
/// is said of a replayed device, which moves nothing.
[[nodiscard]] std::vector<std::string> passivity_warnings(const Scene& scene);

}  // namespace haptic::server
