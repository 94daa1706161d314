#pragma once
/// Planes and contacts as a test tells them, and where they lead a probe.

#include <vector>

#include "haptic/core/contacts/plane_projection.hpp"

namespace haptic::core {

/// n_x lengths.
inline ConfigurationSpace line_space(int n_x) {
  return ConfigurationSpace(std::vector<Coordinate>(static_cast<std::size_t>(n_x)));
}

/// `count` planes without a law, normals and offsets 0.
inline PlaneSet planes_of(int n_x, int count) {
  PlaneSet set;
  set.normals.setZero(n_x, count);
  set.offsets.setZero(count);
  return set;
}

inline VecX led_to(PlaneProjection& projection, const VecX& probe, double age = 0.0,
                   double dt = 0.0) {
  VecX x;
  static_cast<void>(projection.project(probe, x, age, dt));
  return x;
}

/// Fills any vector or matrix.
template <typename Draw, typename Entries>
void fill(Entries& entries, Draw&& draw) {
  for (double& entry : entries.reshaped()) entry = draw();
}

}  // namespace haptic::core
