#pragma once
/// What holds for a scene as a whole, or for one part because of another.

#include "haptic/v1/scene.pb.h"
#include "server/scene/problems.hpp"
#include "server/scene/scene.hpp"

namespace haptic::server {

/// Every text is UTF-8: names of a scene travel in answers, where other bytes would make the whole
/// message unreadable.
void check_text(const google::protobuf::Message& message, const std::string& path,
                Problems& problems);
/// Only a board has a clock of its own to pace the loop by; which of its sample periods is the
/// loop's is known when it has answered (check_pacing of loop_pacing.hpp).
void check_paced_by(const v1::Scene& message, const Scene& scene, Problems& problems);
/// Silence ends force before it ends the lease (proto/README.md#states-of-a-device).
void check_silence(const Scene& scene, Problems& problems);
/// What is recorded goes into no file that the scene plays.
void check_recordings(const Scene& scene, Problems& problems);

}  // namespace haptic::server
