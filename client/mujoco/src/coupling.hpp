#pragma once
/// Springs that pull the tool to its aim.

#include <mujoco/mujoco.h>

#include <cstddef>
#include <vector>

#include "aim.hpp"
#include "bound_tool.hpp"

namespace haptic::mujoco {

class Coupling {
 public:
  /// All stay the caller's, and must live longer.
  Coupling(mjModel& model, mjData& data, const BoundTool& tool, const Aim& aim,
           const ToolOptions& options)
      : model_(&model),
        data_(&data),
        tool_(&tool),
        aim_(&aim),
        options_(&options),
        pulled_(tool.coordinates()) {}

  /// Sets qfrc_applied of all DoFs that the tool pulls. `seen`: where it is, all coordinates. Needs
  /// mj_kinematics, mj_comPos.
  void pull(const std::vector<double>& seen);
  /// Force of the springs in the last pull(), N or N m per coordinate; of a pose only its position.
  [[nodiscard]] const std::vector<double>& pulled() const noexcept { return pulled_; }
  /// c w of a coordinate.
  [[nodiscard]] double stiffness(std::size_t i) const {
    return options_->coupling * (options_->weights.empty() ? 1.0 : options_->weights[i]);
  }

 private:
  void pull_joint(const Place& place, const std::vector<double>& seen);
  void pull_frame(const Place& place);
  void pull_follower(const Follower& follower);

  mjModel* model_;
  mjData* data_;
  const BoundTool* tool_;
  const Aim* aim_;
  const ToolOptions* options_;
  std::vector<double> pulled_;
};

}  // namespace haptic::mujoco
