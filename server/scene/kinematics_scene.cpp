#include "server/scene/kinematics_scene.hpp"

#include "haptic/core/error.hpp"

namespace haptic::server {

SharedKinematics made(const std::function<std::unique_ptr<core::Kinematics>()>& make,
                      const std::string& path, Problems& problems) {
  try {
    return make();
  } catch (const core::SceneError& error) {
    problems.wrong(path, "{ ... }", error.what());
    return nullptr;
  }
}

void check_one_unit(const core::ConfigurationSpace& space, const std::string& path,
                    Problems& problems) {
  if (!space.mixes_units()) return;
  problems.wrong(path, "[metres and radians]",
                 "must be of one unit: a distance over both needs a metric W_x, which a scene "
                 "cannot give yet");
}

}  // namespace haptic::server
