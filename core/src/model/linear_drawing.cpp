#include <algorithm>

#include "drawing_parts.hpp"

namespace haptic::core {

namespace {

using Eigen::Vector3d;

constexpr std::size_t kMostLanes = 8;
constexpr double kCarriage = 2.0, kProbe = 2.5, kPointer = 6.0, kLane = 15.0;  // in radii of a link

double radius_of(const std::vector<DofSpec>& dofs, const MatXQ& A) {
  double longest = 0.0;
  for (std::size_t i = 0; i < dofs.size(); ++i) {
    const double travel = dofs[i].upper - dofs[i].lower;
    longest = std::max(longest, travel * A.col(static_cast<Eigen::Index>(i)).norm());
  }
  return link_radius(longest);
}

/// The DoFs in a row: each carries the next one along its column of A.
Drawing gantry(const std::vector<DofSpec>& dofs, const MatXQ& A, const Vector3d& x_0) {
  const double radius = radius_of(dofs, A);
  const Vector3d origin = Vector3d::Zero();
  Drawing drawing;
  drawing.bodies.push_back({.name = "base", .position = x_0});
  int actuator = 0;
  for (std::size_t i = 0; i < dofs.size(); ++i) {
    const int index = static_cast<int>(i), a = dofs[i].actuated ? actuator++ : -1;
    Vector3d column = origin;
    column.head(A.rows()) = A.col(index);
    const double length = column.norm();
    if (!(length > 0.0)) continue;
    const Vector3d axis = column / length;
    DrawnBody body{.name = dofs[i].name, .parent = static_cast<int>(drawing.bodies.size()) - 1};
    body.motions = {slide_by_q(axis, index)};
    body.motions[0].factor = length;
    body.capsules = {{origin, origin, kCarriage * radius}};
    drawing.bodies.back().capsules.push_back(
        {dofs[i].lower * column, dofs[i].upper * column, radius});
    if (a >= 0) drawing.forces.push_back({.actuator = a, .body = body.parent + 1, .axis = axis});
    drawing.bodies.push_back(std::move(body));
  }
  DrawnBody tool{.name = "tool", .part = DrawnPart::kTool, .motions = place_by_x(0)};
  tool.motions.resize(static_cast<std::size_t>(A.rows()));
  tool.capsules = {{origin, origin, kProbe * radius}};
  drawing.bodies.push_back(std::move(tool));
  return drawing;
}

/// A coordinate on a lane of its own: x_0 + A q moves a body of the device, x one of the tool.
void append_lane(int j, const Coordinate& coordinate, const std::vector<DofSpec>& dofs,
                 const MatXQ& A, double x_0, double radius, Drawing& drawing) {
  const bool slides = coordinate.unit == Unit::kMetre;
  const Vector3d origin = Vector3d::Zero(), along = Vector3d::UnitX();
  const Vector3d axis = slides ? along : Vector3d::UnitZ();
  DrawnMotion by_x = slides ? slide_by_q(axis, j) : turn_by_q(axis, j);
  by_x.value = DrawnValue::kX;
  DrawnBody device{.name = coordinate.name, .position = {0.0, -kLane * radius * j, 0.0}};
  DrawnBody tool = device;
  if (slides) device.position.x() += x_0;
  if (!slides) device.orientation = Eigen::AngleAxisd(x_0, axis);
  tool.part = DrawnPart::kTool;
  tool.motions = {by_x};

  int actuator = 0;
  for (std::size_t i = 0; i < dofs.size(); ++i) {
    const int index = static_cast<int>(i), a = dofs[i].actuated ? actuator++ : -1;
    const double factor = A(j, index);
    if (factor == 0.0) continue;
    DrawnMotion by_q = slides ? slide_by_q(axis, index) : turn_by_q(axis, index);
    by_q.factor = factor;
    device.motions.push_back(by_q);
    if (a < 0) continue;
    drawing.forces.push_back({.actuator = a,
                              .body = static_cast<int>(drawing.bodies.size()),
                              .axis = factor > 0.0 ? axis : Vector3d(-axis),
                              .torque = !slides});
  }
  const Vector3d end = slides ? origin : Vector3d(kPointer * radius * along);
  device.capsules = {{origin, end, kCarriage * radius}};
  tool.capsules = {{origin, end, kProbe * radius}};
  drawing.bodies.push_back(std::move(device));
  drawing.bodies.push_back(std::move(tool));
}

}  // namespace

Drawing linear_drawing(const std::vector<DofSpec>& dofs, const std::vector<Coordinate>& coordinates,
                       const MatXQ& A, const VecX& x_0) {
  if (coordinates.size() > kMostLanes) return {};
  const bool space = coordinates.size() <= 3 &&
                     std::all_of(coordinates.begin(), coordinates.end(),
                                 [](const Coordinate& c) { return c.unit == Unit::kMetre; });
  if (space) {
    Vector3d origin = Vector3d::Zero();
    origin.head(x_0.size()) = x_0;
    return gantry(dofs, A, origin);
  }
  Drawing drawing;
  const double radius = radius_of(dofs, A);
  for (std::size_t j = 0; j < coordinates.size(); ++j) {
    const int row = static_cast<int>(j);
    append_lane(row, coordinates[j], dofs, A, x_0[row], radius, drawing);
  }
  return drawing;
}

}  // namespace haptic::core
