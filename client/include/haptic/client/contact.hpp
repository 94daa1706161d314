#pragma once
/// Contacts for a simulation that knows its own geometry: the place of a point of the tool, how
/// near an object is to it, and how that object gives way. From these contact_at() makes the Plane
/// that the server evaluates at 1 kHz (proto/README.md, Contacts), second order included.
///
///   const auto pad = point_on_finger({0.045, 0.040}, x, 1, 0.03, 0.008);  // on phalanx 1
///   Contact c{.point = pad, .normal = n, .gap = gap, .stiffness = 400.0, .id = 1};
///   c.curvature = sphere_curvature(n, radius + gap);
///   planes.push_back(contact_at(x, c, coupling));
///
/// Frame: any one that the point, the normal and the curvature share and that does not move with
/// the coordinates: the world, or the hand if the joints' angles are all that X has.

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "haptic/client/types.hpp"

namespace haptic::client {

using Vector3 = std::array<double, 3>;

/// A point of the tool, and how it moves with n <= 8 consecutive coordinates.
struct PointMap {
  std::size_t first_coordinate{0};
  Vector3 position{};               ///< p, m
  std::vector<Vector3> jacobian{};  ///< n: dp/dx_j, m per unit of x_j
  /// d2p/dx_j dx_k, m per product of their units: lower triangle, row by row. Empty: 0.
  std::vector<Vector3> second{};
};

/// A joint as it stands now.
struct JointAxis {
  Vector3 origin{};  ///< a point of the axis, m; without a meaning if prismatic
  Vector3 axis{};    ///< of length 1; right-handed
  bool prismatic{false};
};

/// Coordinates: the joints of a serial chain, rad or m, from the base on. `point`: on the last
/// one's link. With a_j and o_j the axes and origins of revolute joints, dp/dx_j = a_j x (p - o_j)
/// and, for j <= k, d2p/dx_j dx_k = a_j x dp/dx_k; a prismatic joint k has dp/dx_k = a_k, and
/// d2p/dx_j dx_k = 0 for a prismatic j.
[[nodiscard]] PointMap point_on_joints(const std::vector<JointAxis>& joints, const Vector3& point,
                                       std::size_t first_coordinate = 0);

/// Coordinates: the flexions of a planar finger (a finger exoskeleton's: MCP, PIP), rad. Frame: the
/// finger's hand frame, origin on the first axis, +x distal, +y dorsal, so that at zero all
/// phalanges lie along +x, and flexion turns them to -y. The point is `along` phalanx number
/// `phalanx` (0, 1, ...) from its joint, and `palmar` of its line, m. `x`: all coordinates, the
/// finger's from `first_coordinate` on. Throws std::out_of_range if x or lengths has too few.
[[nodiscard]] PointMap point_on_finger(const std::vector<double>& lengths,
                                       const std::vector<double>& x, std::size_t phalanx,
                                       double along, double palmar = 0.0,
                                       std::size_t first_coordinate = 0);

/// Coordinates: x, y, z of the point itself (an output of kind point), m. Throws std::out_of_range.
[[nodiscard]] PointMap point_itself(const std::vector<double>& x, std::size_t first_coordinate = 0);

/// Coordinates: x, y, z, m, and a quaternion qx, qy, qz, qw (an output of kind frame, a palm, a
/// stylus), which is normalised, and the derivatives are those of that. `offset`: the point in that
/// frame, m. Throws std::out_of_range.
[[nodiscard]] PointMap point_on_pose(const std::vector<double>& x, const Vector3& offset,
                                     std::size_t first_coordinate = 0);

/// Second derivative of an object's gap by the point, 1/m: the lower triangle xx, yx, yy, zx, zy,
/// zz; all 0: flat.
using Curvature3 = std::array<double, 6>;
/// Curvature of a sphere, and of a cylinder with this axis (of length 1); `distance` of the point
/// from its centre or axis, m, != 0; < 0: the point is inside a hollow one, and the normal points
/// inwards.
[[nodiscard]] Curvature3 sphere_curvature(const Vector3& normal, double distance);
[[nodiscard]] Curvature3 cylinder_curvature(const Vector3& normal, const Vector3& axis,
                                            double distance);

/// A point of the tool against an object. contact_fields.inc has `velocity`, `id`, `mass` and what
/// else a Plane tells as well. An empty `object_direction` is the normal, of a body that does not
/// turn; say it yourself if the points of contacts on one object have different frames, as those of
/// point_on_finger() of two fingers have.
struct Contact {
  PointMap point{};
  Vector3 normal{};  ///< of the object at the nearest point, outwards, of length 1
  double gap{0.0};   ///< from the object to the point along the normal, m; < 0: inside
  Curvature3 curvature{};
  /// k of point and object in series, N/m, > 0. Infinite: rigid.
  double stiffness{std::numeric_limits<double>::infinity()};
#include "haptic/client/contact_fields.inc"
};

/// The contact as the server takes it, linearised at the sample's position `x`: normal = -J^T n,
/// curvature J^T (object's curvature) J + sum_k n_k d2p_k/dx2, compliance = coupling / stiffness.
/// `coupling`: c of the simulation's own coupling, whose energy is c/2 ||x - x_probe||_W^2: N/m if
/// x is in m, N m/rad if in rad. Its units give the gap in m. Throws std::out_of_range if the
/// point's coordinates do not lie within x, or `second` has another size.
[[nodiscard]] Plane contact_at(const std::vector<double>& x, const Contact& contact,
                               double coupling);

/// Fastest point of a finger, m/s. Fingertips in recorded grasps move at 0.29 to 0.54 m/s (99 %);
/// what is told too early costs nothing but a place among the kMaxContactsOfBlock nearest.
inline constexpr double kFastestPoint = 0.5;
/// Contacts with a gap up to this, m, should be told before they are touched: v_max (round trip +
/// period), how far a point may get until the next sample's law is in use. `round_trip`:
/// Session::round_trip(); 0, not known yet: 200 ms are assumed. `period`: of your samples.
[[nodiscard]] double contact_horizon(std::chrono::nanoseconds round_trip,
                                     std::chrono::nanoseconds period, double v_max = kFastestPoint);

}  // namespace haptic::client
