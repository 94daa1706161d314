#include <cmath>
#include <limits>

#include "convert.hpp"
#include "structs.hpp"

namespace haptic::c {

namespace {

/// Lists of a plane or a contact: checked by at_most(), or made by the C++ library.
template <std::size_t kSize>
std::uint32_t write_values(const std::vector<double>& values, double (&to)[kSize]) {
  if (values.size() > kSize) {
    refuse("a list of " + std::to_string(values.size()) + " numbers, must be at most " +
           std::to_string(kSize));
  }
  std::copy(values.begin(), values.end(), to);
  return static_cast<std::uint32_t>(values.size());
}

void at_most(const char* name, std::uint32_t count, std::size_t most) {
  if (count > most) {
    refuse(std::string(name) + " = " + std::to_string(count) + ", must be at most " +
           std::to_string(most));
  }
}

}  // namespace

client::Plane to_plane(const haptic_plane& plane, std::size_t coordinates) {
  at_most("plane.curvature_count", plane.curvature_count, std::size(plane.curvature));
  at_most("plane.object_direction_count", plane.object_direction_count,
          std::size(plane.object_direction));
  client::Plane to;
  to.normal.assign(plane.normal, plane.normal + coordinates);
  to.offset = plane.offset;
  to.compliance = plane.compliance;
  to.velocity = plane.velocity;
  to.curvature.assign(plane.curvature, plane.curvature + plane.curvature_count);
  to.first_coordinate = plane.first_coordinate;
  to.id = plane.id;
  to.mass = plane.mass;
  to.damping = plane.damping;
  to.ground_stiffness = plane.ground_stiffness;
  to.load = plane.load;
  if (plane.has_uncertainty != 0) to.uncertainty = plane.uncertainty;
  to.object = plane.object;
  to.object_direction.assign(plane.object_direction,
                             plane.object_direction + plane.object_direction_count);
  return to;
}

haptic_plane to_plane(const client::Plane& plane) {
  haptic_plane to{};
  write_values(plane.normal, to.normal);
  to.offset = plane.offset;
  to.compliance = plane.compliance;
  to.velocity = plane.velocity;
  to.curvature_count = write_values(plane.curvature, to.curvature);
  to.first_coordinate = plane.first_coordinate;
  to.id = plane.id;
  to.mass = plane.mass;
  to.damping = plane.damping;
  to.ground_stiffness = plane.ground_stiffness;
  to.load = plane.load;
  to.has_uncertainty = plane.uncertainty ? 1 : 0;
  to.uncertainty = plane.uncertainty.value_or(0.0);
  to.object = plane.object;
  to.object_direction_count = write_values(plane.object_direction, to.object_direction);
  return to;
}

client::PointMap to_point(const haptic_point& point) {
  at_most("point.count", point.count, HAPTIC_MAX_POINT_COORDINATES);
  client::PointMap to{point.first_coordinate, to_vector(point.position), {}, {}};
  for (std::size_t j = 0; j < point.count; ++j) to.jacobian.push_back(to_vector(point.jacobian[j]));
  const std::size_t entries = point.has_second != 0 ? point.count * (point.count + 1) / 2 : 0;
  for (std::size_t k = 0; k < entries; ++k) to.second.push_back(to_vector(point.second[k]));
  return to;
}

haptic_point to_point(const client::PointMap& point) {
  haptic_point to{};
  to.first_coordinate = static_cast<std::uint32_t>(point.first_coordinate);
  to.count = static_cast<std::uint32_t>(point.jacobian.size());
  at_most("the coordinates of the point", to.count, HAPTIC_MAX_POINT_COORDINATES);
  to.has_second = point.second.empty() ? 0 : 1;
  const auto copy = [](const client::Vector3& from, double* into) {
    std::copy(from.begin(), from.end(), into);
  };
  copy(point.position, to.position);
  for (std::size_t j = 0; j < to.count; ++j) copy(point.jacobian[j], to.jacobian[j]);
  for (std::size_t k = 0; k < point.second.size(); ++k) copy(point.second[k], to.second[k]);
  return to;
}

client::Contact to_contact(const haptic_contact& contact) {
  at_most("contact->object_direction_count", contact.object_direction_count,
          std::size(contact.object_direction));
  client::Contact to{.point = to_point(read(&contact.point, "contact->point")),
                     .normal = to_vector(contact.normal),
                     .gap = contact.gap,
                     .velocity = contact.velocity,
                     .id = contact.id,
                     .mass = contact.mass,
                     .damping = contact.damping,
                     .ground_stiffness = contact.ground_stiffness,
                     .load = contact.load,
                     .object = contact.object};
  std::copy_n(contact.curvature, to.curvature.size(), to.curvature.begin());
  if (contact.stiffness != 0.0) to.stiffness = contact.stiffness;
  if (contact.has_uncertainty != 0) to.uncertainty = contact.uncertainty;
  to.object_direction.assign(contact.object_direction,
                             contact.object_direction + contact.object_direction_count);
  return to;
}

std::vector<client::Block> to_blocks(const haptic_block* blocks, std::size_t count) {
  std::vector<client::Block> to;
  for (std::size_t i = 0; i < count; ++i) to.push_back({blocks[i].first, blocks[i].count});
  return to;
}

std::vector<double> to_position(const double* x, std::size_t count, std::size_t coordinates) {
  given(x, "x");
  if (count != coordinates) {
    refuse("count = " + std::to_string(count) + ", must be " + std::to_string(coordinates) +
           ", one value per coordinate of the device");
  }
  std::vector<double> position(x, x + count);
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(x[i])) {
      refuse("x[" + std::to_string(i) + "] = " + std::to_string(x[i]) + ", must be finite");
    }
  }
  return position;
}

}  // namespace haptic::c
