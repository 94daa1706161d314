#pragma once
/// --set path=value: one field of the scene, by its path.
///   device[0].impedance.stiffness_n_per_m[0]=800      one entry of a list
///   device[0].impedance.stiffness_n_per_m=[800]       the whole list
///   server.listen[1]=unix:/run/hapticd.sock           index = size appends;
///   quotes may be left out device[0].direction_guard={} presence selects
///   device[0].standard={}                             replaces the other
///   member of a oneof

#include <string>

#include "haptic/v1/scene.pb.h"

namespace haptic::server {

/// Sets the field, creating the messages on the way; returns its path. Throws
/// SceneError: what is not of the form path=value, a step that does not exist
/// (with what does), a value that the field does not take. `scene` is unchanged
/// then.
std::string apply_override(const std::string& assignment, v1::Scene& scene);

}  // namespace haptic::server
