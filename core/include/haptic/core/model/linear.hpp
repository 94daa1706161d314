#pragma once
/// The linear map x = x_0 + A q: the map on which every rule of the method can be checked by hand.

#include <memory>
#include <vector>

#include "haptic/core/model/kinematics.hpp"

namespace haptic::core {

struct LinearMap {
  std::vector<DofSpec> dofs{};
  std::vector<Coordinate> coordinates{};
  MatXQ A{};   ///< n_x by n_q
  VecX x_0{};  ///< n_x
};

/// Throws SceneError: shapes that do not fit, entries that are not finite, limits out of order.
[[nodiscard]] std::unique_ptr<Kinematics> make_linear(const LinearMap& map);

}  // namespace haptic::core
