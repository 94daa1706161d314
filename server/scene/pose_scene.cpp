#include "server/scene/pose_scene.hpp"

#include <cmath>

#include "server/scene/entry_name.hpp"

namespace haptic::server {

core::Point3 read_triple(const FieldReader& reader, const char* field,
                         const core::Point3& fallback) {
  const std::vector<double> values =
      reader.list({field, Allowed::kFinite, 3, "axis"},
                  std::vector<double>{fallback.x, fallback.y, fallback.z});
  return values.size() == 3 ? core::Point3{values[0], values[1], values[2]} : core::Point3{};
}

core::Pose3 read_point(v1::PointScene& message, const std::string& path, Problems& problems) {
  return {read_triple(FieldReader(message, path, problems), "position_m", {}), {}};
}

core::Pose3 read_pose(v1::PoseScene& message, const std::string& path, Problems& problems) {
  const FieldReader reader(message, path, problems);
  core::Pose3 pose;
  pose.position = read_triple(reader, "position_m", {});
  const std::vector<double> q = reader.list({"orientation", Allowed::kFinite, 4, "part x, y, z, w"},
                                            std::vector<double>{0.0, 0.0, 0.0, 1.0});
  if (q.size() != 4) return pose;
  pose.orientation = {q[0], q[1], q[2], q[3]};
  if (!(std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3])) > 1e-6)) {
    reader.wrong("orientation", decimal(q), "must be a quaternion other than zero");
  }
  return pose;
}

core::TrackedPalm read_palm(v1::PalmScene& message, const std::string& path, Problems& problems) {
  const FieldReader reader(message, path, problems);
  core::TrackedPalm palm;
  if (message.name().empty()) message.set_name(palm.name);
  palm.name = message.name();
  std::set<std::string> names;
  check_entry_name(reader, palm.name, kLongestPartName, names);
  reader.numbers({{"position_lower_m", &palm.position_lower, Allowed::kFinite},
                  {"position_upper_m", &palm.position_upper, Allowed::kFinite}});
  if (palm.position_upper <= palm.position_lower) {
    reader.wrong("position_upper_m", decimal(palm.position_upper),
                 "must be above its lower limit, " + decimal(palm.position_lower));
  }
  return palm;
}

}  // namespace haptic::server
