#pragma once
/// Changes of the scene's settings that a session may make: tighten, never widen
/// (proto/README.md#a-session).

#include <optional>
#include <string>
#include <vector>

#include "haptic/core/safety/lifecycle.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "haptic/core/tick/tick_input.hpp"
#include "server/crossing/outcome.hpp"

namespace haptic::server {

struct SettingsAnswer {
  core::RenderSettings applied{};
  /// Settings that were held at the scene's, a sentence each: "stiffness[0] = 9: held at 3, ...".
  std::vector<std::string> clamped{};
};

/// `current` with `request` applied, held within the scene's. Values above the scene's are clamped
/// and reported; refused are: sizes other than n_a, values that are not finite, negative values
/// (slew: not above 0), a change of renderer outside IDLE and ARMED, or to a baseline if the scene
/// couples Z_q, switching off the scene's guard. The id of the answer's settings is the caller's to
/// set.
[[nodiscard]] Outcome<SettingsAnswer> apply_settings(const SettingsRequest& request,
                                                     const core::RenderSettings& current,
                                                     const core::PipelineConfig& config,
                                                     core::LifecycleState state);

/// The staleness limits of a new lease (proto/README.md#staleness-and-gain). Each of the scene's
/// (fresh_end: 2.5 nominal periods, at most `fresh_bound` and hold_end), or the request's if
/// that is tighter; a wider wish is held at the scene's. Refused: a nominal rate outside 1..2000
/// Hz, a limit <= 0, and wishes that do not hold together with the rest.
[[nodiscard]] Outcome<core::StalenessLimits> lease_staleness(
    const LeaseRequest& request, const core::StalenessLimits& scene,
    std::optional<core::Duration> fresh_bound);

}  // namespace haptic::server
