#pragma once
/// A client's planes as the server's ingress gives them to the pipeline.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "haptic/client/types.hpp"
#include "haptic/core/contacts/proxy_snapshot.hpp"

namespace haptic::test {

/// Every plane has `n_x` coordinates.
[[nodiscard]] inline core::PlaneSet plane_set(const std::vector<client::Plane>& planes, int n_x) {
  core::PlaneSet set;
  const auto count = static_cast<Eigen::Index>(planes.size());
  set.normals.resize(n_x, count);
  set.offsets.resize(count);
  set.compliance.resize(count);
  set.velocity.resize(count);
  set.laws.resize(4, count);
  set.ids.resize(count);
  const bool shared = std::any_of(planes.begin(), planes.end(),
                                  [](const client::Plane& p) { return p.object != 0; });
  set.objects.setZero(Eigen::NoChange, shared ? count : 0);
  const bool known = std::all_of(planes.begin(), planes.end(),
                                 [](const client::Plane& p) { return p.uncertainty.has_value(); });
  set.uncertainty.resize(known ? count : 0);
  std::vector<double> curvatures;
  for (Eigen::Index p = 0; p < count; ++p) {
    const client::Plane& plane = planes[static_cast<std::size_t>(p)];
    set.normals.col(p) = Eigen::Map<const Eigen::VectorXd>(plane.normal.data(), n_x);
    set.offsets[p] = plane.offset;
    set.compliance[p] = plane.compliance;
    set.velocity[p] = plane.velocity;
    if (known) set.uncertainty[p] = *plane.uncertainty;
    set.laws.col(p) << plane.mass, plane.damping, plane.ground_stiffness, plane.load;
    set.ids[p] = plane.id;
    if (shared) set.objects(0, p) = plane.object;
    for (std::size_t k = 0; shared && k < plane.object_direction.size(); ++k) {
      set.objects(static_cast<Eigen::Index>(1 + k), p) = plane.object_direction[k];
    }
    curvatures.insert(curvatures.end(), plane.curvature.begin(), plane.curvature.end());
    int n = 0;
    while (core::PlaneSet::triangle(n) < static_cast<int>(plane.curvature.size())) ++n;
    set.first[static_cast<std::size_t>(p)] = static_cast<std::uint8_t>(plane.first_coordinate);
    set.curved[static_cast<std::size_t>(p)] = static_cast<std::uint8_t>(n);
  }
  set.curvature = Eigen::Map<const Eigen::VectorXd>(curvatures.data(),
                                                    static_cast<Eigen::Index>(curvatures.size()));
  return set;
}

}  // namespace haptic::test
