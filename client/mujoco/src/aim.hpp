#pragma once
/// Where the tool is to be, step by step: at the probe at the end of each sample's period, or on
/// the way there if the probe jumped.

#include <vector>

#include "bound_tool.hpp"

namespace haptic::mujoco {

class Aim {
 public:
  Aim(const BoundTool& tool, const ToolOptions& options) : tool_(&tool), options_(&options) {}

  /// The tool is at x, and does not follow.
  void begin(std::vector<double> x);
  /// The next `steps` steps, of `seconds` in all, go to `probe`; empty: they stay.
  void next(const std::vector<double>& probe, int steps, double seconds);
  /// One step more; beyond the last the aim stays.
  void step();

  /// Coordinate i now; a quaternion's parts are to be normalised.
  [[nodiscard]] double at(std::size_t i) const { return from_[i] + part_ * (to_[i] - from_[i]); }
  [[nodiscard]] double way(std::size_t i) const { return to_[i] - from_[i]; }  ///< of all steps
  [[nodiscard]] double rate(std::size_t i) const { return way(i) / seconds_; }
  [[nodiscard]] double seconds() const noexcept { return seconds_; }
  [[nodiscard]] bool following() const noexcept { return following_; }

 private:
  /// The part of the way to the goal that is gone in this period, 1: all of it. Writes angles and
  /// quaternions of the goal as near to the aim as they can be said.
  [[nodiscard]] double part_of_way(std::vector<double>& goal) const;

  const BoundTool* tool_;
  const ToolOptions* options_;
  std::vector<double> from_{}, to_{};
  double seconds_{1.0}, part_{1.0};
  int steps_{1}, taken_{1};
  bool following_{false};
};

}  // namespace haptic::mujoco
