#include "server/scene/tracker_scene.hpp"

#include "hw/replay/tracked_orientation.hpp"
#include "server/scene/staleness_scene.hpp"

namespace haptic::server {

std::optional<TrackerRead> read_tracker(v1::StalenessScene& message, const std::string& path,
                                        const core::Kinematics* kinematics, Problems& problems) {
  const StalenessRead staleness = read_staleness(message, path, problems);
  if (kinematics == nullptr) return std::nullopt;
  // A palm stands in q as x, y, z and then its rotation vector (core, TrackedPalm).
  constexpr std::size_t kPosition = 3;
  const auto rotation = hw::rotation_vector_in(kinematics->dofs());
  if (!rotation || *rotation < kPosition) {
    problems.wrong(path, "{ ... } with a device that has no tracked palm",
                   "must go with tracked_hand, or with a serial_chain on a palm");
    return std::nullopt;
  }
  return TrackerRead{{static_cast<int>(*rotation - kPosition), staleness.limits},
                     staleness.fresh_end};
}

}  // namespace haptic::server
