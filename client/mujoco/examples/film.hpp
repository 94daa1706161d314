#pragma once
/// A film and a picture of a haptic MuJoCo simulation, made after the run, so that they take no
/// time from it: the proxy as it was, the probe as a ghost, the forces on the tool as arrows, the
/// device's own as bars. Drawn without a screen, by EGL.

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "haptic/client/state.hpp"
#include "haptic/client/types.hpp"
#include "haptic/mujoco/tool.hpp"

namespace haptic::examples {

/// A normal force on the tool, N, and its place, m, in the world.
struct Touch {
  double position[3];
  double force[3];
};

/// All contacts of the tool that press now.
[[nodiscard]] std::vector<Touch> touches_of(const mjModel& model, const mjData& data,
                                            const mujoco::Tool& tool);

struct FilmFrame {
  std::vector<mjtNum> qpos{};
  std::vector<double> x_probe{};
  std::vector<double> tau_a{};  ///< N or N m per actuated DoF
  std::vector<Touch> touches{};
};

struct FilmOptions {
  std::string film{}, picture{};  ///< WebM and PNG; empty: none
  [[nodiscard]] bool wanted() const { return !film.empty() || !picture.empty(); }
};

/// Draws `frames`, which are 60 per second. The film shows every second frame. The picture shows
/// the frame with the most contacts among those with the most force. `model` is one as the run
/// began with. Camera: the model's first. Throws std::runtime_error: no EGL, or no ffmpeg.
void render(const FilmOptions& options, mjModel& model,
            const std::vector<mujoco::Binding>& bindings, const mujoco::ToolOptions& coupled,
            const client::DeviceInfo& device, const std::vector<FilmFrame>& frames);

}  // namespace haptic::examples
