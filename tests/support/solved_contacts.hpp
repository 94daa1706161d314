#pragma once
/// The proxy of flat contacts by another way than the product's: slow, and with no limit on what
/// they are.

#include <algorithm>
#include <cmath>

#include "haptic/core/contacts/proxy_snapshot.hpp"

namespace haptic::test {

/// argmin 1/2 |x - p|^2 + 1/2 sum max(0, n^T x - b)^2 / gamma, by sweeps over the multipliers.
[[nodiscard]] inline core::VecX solved(const core::PlaneSet& set, const core::VecX& p) {
  core::VecX x = p;
  core::VecX l = core::VecX::Zero(set.size());
  for (int sweep = 0; sweep < 20000; ++sweep) {
    double moved = 0.0;
    for (int i = 0; i < set.size(); ++i) {
      const auto n = set.normals.col(i);
      const double step = (n.dot(x) - set.offsets[i] - set.compliance[i] * l[i]) /
                          (n.squaredNorm() + set.compliance[i]);
      const double next = std::max(0.0, l[i] + step);
      x -= (next - l[i]) * n;
      moved = std::max(moved, std::abs(next - l[i]));
      l[i] = next;
    }
    if (moved < 1e-14) break;
  }
  return x;
}

}  // namespace haptic::test
