#pragma once
/// How far away MuJoCo finds contacts of the tool.

#include <vector>

#include "bound_tool.hpp"

namespace haptic::mujoco {

/// Margin and gap of the tool's geoms and pairs in the model, and as they were there.
class Margins {
 public:
  Margins(mjModel& model, const BoundTool& tool);
  /// MuJoCo finds contacts up to `horizon` m farther away, and begins their force where it did.
  void grow(double horizon);

 private:
  struct Margin {
    mjtNum *margin, *gap;        ///< of a geom or a pair, in the model
    double own_margin, own_gap;  ///< m, as the model had them
  };
  std::vector<Margin> margins_{};
};

}  // namespace haptic::mujoco
