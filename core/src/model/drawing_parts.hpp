#pragma once
/// Parts from which the drawings of the maps are put together.

#include <string>

#include "haptic/core/model/drawing.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/kinematics.hpp"

namespace haptic::core {

/// Where the drawing of a part goes within that of a whole.
struct DrawnPlace {
  std::string prefix{};  ///< of its bodies' names
  int parent{-1};        ///< body of the whole
  Eigen::Vector3d position{Eigen::Vector3d::Zero()};
  Eigen::Quaterniond orientation{Eigen::Quaterniond::Identity()};
  int first_q{0};  ///< indices of its first DoF, actuated DoF and coordinate
  int first_a{0};
  int first_x{0};
  bool with_tool{true};
};

void append(const Drawing& part, const DrawnPlace& place, Drawing& whole);

/// Radius of a link where `longest` is the longest distance in the drawing, m.
[[nodiscard]] double link_radius(double longest) noexcept;

/// Turns or slides by the DoF q[index].
[[nodiscard]] DrawnMotion turn_by_q(const Eigen::Vector3d& axis, int index);
[[nodiscard]] DrawnMotion slide_by_q(const Eigen::Vector3d& axis, int index);
/// Slides along x, y and z by x[first], x[first + 1] and x[first + 2].
[[nodiscard]] std::vector<DrawnMotion> place_by_x(int first);

/// The linkage on a finger and the finger itself, in the hand frame. The device's bodies come
/// first.
[[nodiscard]] Drawing finger_drawing(const FingerDimensions& dimensions);

/// x = x_0 + A q. Up to three lengths are the axes of space, in which the DoFs carry each other as
/// those of a gantry; other coordinates lie next to each other, a slider or a pointer each. More
/// than eight are not drawn.
[[nodiscard]] Drawing linear_drawing(const std::vector<DofSpec>& dofs,
                                     const std::vector<Coordinate>& coordinates, const MatXQ& A,
                                     const VecX& x_0);

}  // namespace haptic::core
