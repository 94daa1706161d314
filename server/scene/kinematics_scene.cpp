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

}  // namespace haptic::server
