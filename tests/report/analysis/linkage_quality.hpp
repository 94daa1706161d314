#pragma once
/// Measures of a linkage of the finger over the workspace [0,80] x [0,90] deg:
/// tests/report/STUDY.md#choice-of-the-linkage. w is the gradient of q_a(x), m/rad: the torque at
/// each joint of 1 N at the actuator.

#include <optional>

#include "haptic/core/model/finger_exoskeleton.hpp"

namespace haptic::core {

/// One pose that the linkage reaches.
struct LinkageNode {
  double l{0.0};             ///< m
  double c1{0.0}, c2{0.0};   ///< m
  double w1{0.0}, w2{0.0};   ///< m/rad at MCP and PIP
  double condition{0.0};     ///< of J, with l in units of 20 mm
  double pivot_height{0.0};  ///< of the carriage's pivot over the MCP axis, m
};

/// The pose at the joint angles (rad); none if a slider, the stroke or q_B would leave its range.
[[nodiscard]] std::optional<LinkageNode> linkage_node(const FingerDimensions& dimensions,
                                                      double mcp, double pip);

struct Range {
  double lowest{1e9};
  double highest{-1e9};
  void add(double value);
  [[nodiscard]] double width() const { return highest - lowest; }
};

struct LinkageQuality {
  double reach{0.0};          ///< share of the workspace
  double with_straight{0.0};  ///< share of the workspace and of the overstretched finger
  double both_positive{0.0};  ///< share of the poses reached with w1, w2 > 0
  double both_strong{0.0};    ///< with w1, w2 >= 5 mm/rad
  Range w1{}, w2{}, c1{}, c2{}, condition{}, pivot_height{};
  double median_condition{0.0};
  double median_felt_mcp{0.0}, median_felt_pip{0.0};  ///< w Z w^T at 1500 N/m, N m/rad
  double stroke{0.0};  ///< of the workspace and the overstretched finger, m
};

/// Over the workspace, and [-15,0] x [0,70] deg, where a straight finger is overstretched, on a
/// grid of `step` degrees.
[[nodiscard]] LinkageQuality linkage_quality(const FingerDimensions& dimensions, double step);

}  // namespace haptic::core
