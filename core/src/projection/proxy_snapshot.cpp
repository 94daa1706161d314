#include "haptic/core/projection/proxy_snapshot.hpp"

namespace haptic::core {

bool PlaneSet::fits(int n_x) const noexcept {
  const Eigen::Index count = offsets.size();
  const auto none_or_all = [count](const Offsets& v) {
    return (v.size() == 0 || v.size() == count) && v.allFinite();
  };
  if (count == 0) return true;
  if (normals.rows() != n_x || normals.cols() != count || !normals.allFinite() ||
      !offsets.allFinite() || !none_or_all(compliance) || !none_or_all(velocity) ||
      !none_or_all(uncertainty) || !none_or_all(ids) ||
      (laws.cols() != 0 && laws.cols() != count) || !laws.allFinite() ||
      (objects.cols() != 0 && objects.cols() != count) || !objects.allFinite()) {
    return false;
  }
  if (!curvature.allFinite()) return false;
  int numbers = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    if (curved[i] > kMaxCurved || first[i] + curved[i] > n_x) return false;
    numbers += triangle(curved[i]);
  }
  return numbers == curvature.size();
}

}  // namespace haptic::core
