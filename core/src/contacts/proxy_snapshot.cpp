#include "haptic/core/contacts/proxy_snapshot.hpp"

namespace haptic::core {

namespace {

/// 0 times what is not finite is not 0. A sum is made of several numbers at once, which Eigen's
/// allFinite() is not.
template <typename Numbers>
bool finite(const Numbers& v) noexcept {
  return (0.0 * v).sum() == 0.0;
}

}  // namespace

bool PlaneSet::fits(int n_x) const noexcept {
  const Eigen::Index count = offsets.size();
  const auto none_or_all = [count](const Offsets& v) {
    return (v.size() == 0 || v.size() == count) && finite(v);
  };
  if (count == 0) return true;
  if (normals.rows() != n_x || normals.cols() != count || !finite(normals) || !finite(offsets) ||
      !std::apply([&](const auto&... list) { return (none_or_all(list) && ...); }, lists()) ||
      !none_or_all(ids) || (laws.cols() != 0 && laws.cols() != count) || !finite(laws) ||
      (objects.cols() != 0 && objects.cols() != count) || !finite(objects)) {
    return false;
  }
  if (!finite(curvature)) return false;
  int numbers = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    if (curved[i] > kMaxCurved || first[i] + curved[i] > n_x) return false;
    numbers += triangle(curved[i]);
  }
  return numbers == curvature.size();
}

}  // namespace haptic::core
