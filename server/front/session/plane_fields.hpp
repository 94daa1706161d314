#pragma once
/// The numbers of a plane, from its message to the value that crosses.

#include "haptic/v1/session.pb.h"
#include "server/crossing/crossing.hpp"

namespace haptic::server {

/// Generated. The lists of a plane are the caller's to read.
void read_fields(const v1::Plane& from, PlaneSample& to);

}  // namespace haptic::server
