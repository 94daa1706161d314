#pragma once
/// --set path=value: one field of the scene, by its path. Creates messages on the way, appends with
/// [size], replaces the other member of a oneof.

#include <string>

#include "haptic/v1/scene.pb.h"

namespace haptic::server {

/// Throws SceneError naming the path, the step that is off, and what exists there.
void apply_override(const std::string& assignment, v1::Scene& scene);

}  // namespace haptic::server
