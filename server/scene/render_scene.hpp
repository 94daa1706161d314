#pragma once
/// What is rendered on a device, and within which limits.

#include <memory>
#include <optional>

#include "haptic/core/linear/stiffness_coupling.hpp"
#include "haptic/core/tick/tick_input.hpp"
#include "haptic/v1/scene.pb.h"
#include "server/scene/problems.hpp"

namespace haptic::server {

struct RenderScene {
  core::RenderSettings settings{};
  std::shared_ptr<const core::StiffnessCoupling> coupling{};  ///< of Z_q; null: it is diagonal
  std::optional<core::Duration> fresh_end{};                  ///< as given in the scene
};

/// Reads impedance, limits, staleness, renderer and guard of a device whose
/// path is `path`, and fills in their defaults. `n_a` -1: not known, sizes are
/// not looked at. `max_effort` empty: not known.
[[nodiscard]] RenderScene read_render(v1::DeviceScene& message, const std::string& path, int n_a,
                                      const core::VecA& max_effort, Problems& problems);

}  // namespace haptic::server
