#include <cmath>
#include <limits>

#include "convert.hpp"
#include "convert_plane.hpp"

namespace haptic::c {

client::Plane to_plane(const haptic_plane& plane, std::size_t coordinates) {
  client::Plane to;
  to.normal.assign(plane.normal, plane.normal + coordinates);
  read_fields(plane, to);
  return to;
}

haptic_plane to_plane(const client::Plane& plane) {
  haptic_plane to{};
  write_values(plane.normal, to.normal);
  write_fields(plane, to);
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
  if (contact.point.size != sizeof contact.point) {  // it cannot grow within the contact
    refuse("contact->point->size = " + std::to_string(contact.point.size) +
           ", must be sizeof contact->point (" + std::to_string(sizeof contact.point) + ")");
  }
  client::Contact to{
      .point = to_point(contact.point), .normal = to_vector(contact.normal), .gap = contact.gap};
  read_fields(contact, to);
  std::copy_n(contact.curvature, to.curvature.size(), to.curvature.begin());
  if (contact.stiffness != 0.0) to.stiffness = contact.stiffness;
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
