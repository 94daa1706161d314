#include "haptic/client/contact.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "haptic/client/planes.hpp"
#include "told.hpp"

namespace haptic::client {

namespace {

constexpr std::chrono::milliseconds kUnknownRoundTrip{200};

Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vector3 minus(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
double dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Entry of a lower triangle, row by row.
constexpr std::size_t at(std::size_t row, std::size_t column) {
  return row * (row + 1) / 2 + column;
}

/// (K v)_i of a symmetric K.
Vector3 times(const Curvature3& K, const Vector3& v) {
  return {K[0] * v[0] + K[1] * v[1] + K[3] * v[2], K[1] * v[0] + K[2] * v[1] + K[4] * v[2],
          K[3] * v[0] + K[4] * v[1] + K[5] * v[2]};
}

/// (1 - sum of a a^T) / distance.
Curvature3 across(std::initializer_list<Vector3> directions, double distance) {
  Curvature3 K{1.0, 0.0, 1.0, 0.0, 0.0, 1.0};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      for (const Vector3& a : directions) K[at(i, j)] -= a[i] * a[j];
      K[at(i, j)] /= distance;
    }
  }
  return K;
}

}  // namespace

PointMap point_on_joints(const std::vector<JointAxis>& joints, const Vector3& point,
                         std::size_t first_coordinate) {
  PointMap map{first_coordinate, point, {}, {}};
  for (const JointAxis& joint : joints) {
    map.jacobian.push_back(joint.prismatic ? joint.axis
                                           : cross(joint.axis, minus(point, joint.origin)));
  }
  // A joint turns everything beyond it, and so the derivatives by the joints that it carries.
  for (std::size_t k = 0; k < joints.size(); ++k) {
    for (std::size_t j = 0; j <= k; ++j) {
      map.second.push_back(joints[j].prismatic ? Vector3{}
                                               : cross(joints[j].axis, map.jacobian[k]));
    }
  }
  return map;
}

PointMap point_on_finger(const std::vector<double>& lengths, const std::vector<double>& x,
                         std::size_t phalanx, double along, double palmar,
                         std::size_t first_coordinate) {
  std::vector<JointAxis> joints;
  Vector3 origin{};
  double angle = 0.0;
  for (std::size_t k = 0; k <= phalanx; ++k) {
    if (k > 0) {
      origin[0] += lengths.at(k - 1) * std::cos(angle);
      origin[1] -= lengths.at(k - 1) * std::sin(angle);
    }
    angle += x.at(first_coordinate + k);
    joints.push_back({origin, {0.0, 0.0, -1.0}, false});
  }
  const double c = std::cos(angle), s = std::sin(angle);
  return point_on_joints(
      joints, {origin[0] + along * c - palmar * s, origin[1] - along * s - palmar * c, 0.0},
      first_coordinate);
}

PointMap point_itself(const std::vector<double>& x, std::size_t first_coordinate) {
  const std::size_t i = first_coordinate;
  return {i, {x.at(i), x.at(i + 1), x.at(i + 2)}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}};
}

PointMap point_on_pose(const std::vector<double>& x, const Vector3& offset,
                       std::size_t first_coordinate) {
  PointMap map = point_itself(x, first_coordinate);
  double q[4], square = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    q[i] = x.at(first_coordinate + 3 + i);
    square += q[i] * q[i];
  }
  const double length = std::sqrt(square);
  for (double& part : q) part /= length;
  // R r = q r q* is a quadratic form of q with the second derivative 2 M: by v = (qx, qy, qz) and w
  // it is (w^2 - v.v) r + 2 v (v.r) + 2 w v x r.
  const Vector3 r = offset, v{q[0], q[1], q[2]};
  const double w = q[3];
  Vector3 turned = cross(v, r);
  for (std::size_t k = 0; k < 3; ++k) {
    turned[k] = (w * w - dot(v, v)) * r[k] + 2.0 * v[k] * dot(v, r) + 2.0 * w * turned[k];
    map.position[k] += turned[k];
  }
  Vector3 twice_M[4][4];
  for (std::size_t i = 0; i < 3; ++i) {
    Vector3 unit_i{};
    unit_i[i] = 1.0;
    const Vector3 turn = cross(unit_i, r);
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t j = 0; j < 3; ++j) {
        twice_M[i][j][k] =
            2.0 * ((k == i ? r[j] : 0.0) + (k == j ? r[i] : 0.0) - (i == j ? r[k] : 0.0));
      }
      twice_M[i][3][k] = twice_M[3][i][k] = 2.0 * turn[k];
    }
  }
  for (std::size_t k = 0; k < 3; ++k) twice_M[3][3][k] = 2.0 * r[k];
  // The derivatives of q^T M q / q^T q.
  Vector3 slope[4]{};  // 2 M q
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t j = 0; j < 4; ++j) slope[i][k] += twice_M[i][j][k] * q[j];
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    Vector3 column;
    for (std::size_t k = 0; k < 3; ++k) column[k] = (slope[i][k] - 2.0 * q[i] * turned[k]) / length;
    map.jacobian.push_back(column);
  }
  map.second.resize(at(6, 6) + 1);
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double bend = twice_M[i][j][k] - 2.0 * (slope[i][k] * q[j] + slope[j][k] * q[i]) +
                            (8.0 * q[i] * q[j] - (i == j ? 2.0 : 0.0)) * turned[k];
        map.second[at(3 + i, 3 + j)][k] = bend / square;
      }
    }
  }
  return map;
}

Curvature3 sphere_curvature(const Vector3& normal, double distance) {
  return across({normal}, distance);
}

Curvature3 cylinder_curvature(const Vector3& normal, const Vector3& axis, double distance) {
  return across({normal, axis}, distance);
}

Plane contact_at(const std::vector<double>& x, const Contact& contact, double coupling) {
  const PointMap& point = contact.point;
  const std::size_t first = point.first_coordinate, n = point.jacobian.size();
  if (first > x.size() || n > x.size() - first) {
    throw std::out_of_range("point.first_coordinate " + std::to_string(first) + ", " +
                            std::to_string(n) + " coordinates: must lie within the " +
                            std::to_string(x.size()) + " of x");
  }
  if (!point.second.empty() && point.second.size() != n * (n + 1) / 2) {
    throw std::out_of_range("point.second: has " + std::to_string(point.second.size()) +
                            " vectors, must have 0 or " + std::to_string(n * (n + 1) / 2) +
                            " for " + std::to_string(n) + " coordinates");
  }
  std::vector<double> gradient(x.size(), 0.0);
  for (std::size_t j = 0; j < n; ++j) gradient[first + j] = dot(contact.normal, point.jacobian[j]);
  Plane plane = haptic::client::contact(x, contact.gap, gradient);
  plane.compliance = coupling / contact.stiffness;
  plane.first_coordinate = static_cast<std::uint32_t>(first);
  tell(contact, coupling, plane);
  if (plane.object != 0 && plane.object_direction.empty()) {
    plane.object_direction.assign(contact.normal.begin(), contact.normal.end());
  }
  bool curved = false;
  for (std::size_t j = 0; j < n; ++j) {
    const Vector3 bent = times(contact.curvature, point.jacobian[j]);
    for (std::size_t k = 0; k <= j; ++k) {
      double value = dot(point.jacobian[k], bent);
      if (!point.second.empty()) value += dot(contact.normal, point.second[at(j, k)]);
      plane.curvature.push_back(value);
      curved = curved || value != 0.0;
    }
  }
  if (!curved) plane.curvature.clear();
  return plane;
}

double contact_horizon(std::chrono::nanoseconds round_trip, std::chrono::nanoseconds period,
                       double v_max) {
  if (round_trip.count() <= 0) round_trip = kUnknownRoundTrip;
  return v_max * std::chrono::duration<double>(round_trip + period).count();
}

}  // namespace haptic::client
