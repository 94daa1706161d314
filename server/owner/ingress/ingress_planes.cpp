/// The ingress's part that reads planes and contacts.

#include <algorithm>
#include <cmath>

#include "server/owner/ingress/ingress.hpp"
#include "server/owner/ingress/plane_fields.hpp"
#include "server/owner/ingress/refused.hpp"

namespace haptic::server {
namespace {

/// Below this a normal is none: its square would leave the range of a double.
constexpr double kSmallestNormal = 1e-100;
/// Error of a length of 1: a sum of six products may be off by it in single precision.
constexpr double kOffUnit = 1e-3;

/// n of a lower triangle with `count` values; 0: there is none, or none that is allowed.
constexpr std::uint32_t curved_coordinates(std::uint32_t count) noexcept {
  for (std::uint32_t n = 1; n <= core::kMaxCurved; ++n) {
    if (count == n * (n + 1) / 2) return n;
  }
  return 0;
}

}  // namespace

Ingress::Refused Ingress::check_planes(const ProxySample& sample) const {
  constexpr auto kBad = IngressVerdict::kBadPlane;
  if (sample.mode != core::ProxyMode::kPlanes) return refused(kBad, "planes: only in mode PLANES");
  if (sample.plane_count > core::kMaxPlanes) {
    return refused(kBad, "planes has {} entries: at most {}", sample.plane_count, core::kMaxPlanes);
  }
  int curvatures = 0;
  for (std::size_t p = 0; p < sample.plane_count; ++p) {
    const PlaneSample& plane = sample.planes[p];
    if (plane.normal.count != n_x_) {
      return refused(kBad,
                     "planes[{}].normal has {} values: must have {}, one per virtual coordinate", p,
                     plane.normal.count, n_x_);
    }
    const Eigen::Map<const Eigen::ArrayXd> normal(plane.normal.value.data(), n_x_);
    const double largest = normal.abs().maxCoeff<Eigen::PropagateNaN>();
    for (Eigen::Index i = 0; !(largest <= kLargestNormal) && i < n_x_; ++i) {
      if (std::abs(normal[i]) <= kLargestNormal) continue;
      return refused(kBad, "planes[{}].normal[{}] = {:.6g}: must lie within +-1e6", p, i,
                     normal[i]);
    }
    if (!(largest >= kSmallestNormal)) {
      return refused(kBad, "planes[{}].normal = {:.6g}: must have a direction", p, largest);
    }
    if (auto wrong = check_fields(plane, p)) return wrong;
    if (auto wrong = check_contact(sample, p)) return wrong;
    curvatures += static_cast<int>(plane.curvature_count);
  }
  if (curvatures > core::kMaxCurvature) {
    return refused(kBad, "planes: their curvatures have {} values: at most {} together", curvatures,
                   core::kMaxCurvature);
  }
  return {};
}

/// Checks what makes a plane a contact.
Ingress::Refused Ingress::check_contact(const ProxySample& sample, std::size_t p) const {
  constexpr auto kBad = IngressVerdict::kBadPlane;
  const PlaneSample& plane = sample.planes[p];
  if (auto wrong = check_law(plane, p)) return wrong;
  const std::uint32_t count = plane.curvature_count, n = curved_coordinates(count);
  if (count > 0 && n == 0) {
    return refused(kBad, "planes[{}].curvature has {} values: must have n (n + 1) / 2, n <= 8", p,
                   count);
  }
  if (n_x_ + count > PlaneSample::kNumbers) {
    return refused(kBad, "planes[{}].curvature has {} values: at most {} with {} coordinates", p,
                   count, PlaneSample::kNumbers - n_x_, n_x_);
  }
  if (count > 0 && (plane.first_coordinate > n_x_ || n > n_x_ - plane.first_coordinate)) {
    return refused(kBad, "planes[{}].first_coordinate = {}: must leave room for {} of {}", p,
                   plane.first_coordinate, n, n_x_);
  }
  for (std::size_t k = 0; k < count; ++k) {
    const double value = plane.normal.value[n_x_ + k];
    if (!(std::abs(value) <= kLargestCurvature)) {
      return refused(kBad, "planes[{}].curvature[{}] = {:.6g}: must lie within +-1e9", p, k, value);
    }
  }
  for (std::size_t other = 0; other < p && plane.id != 0; ++other) {
    if (sample.planes[other].id == plane.id) {
      return refused(kBad, "planes[{}].id = {}: must be unique, planes[{}] has it too", p, plane.id,
                     other);
    }
  }
  return {};
}

/// No mass is too small for the loop's period: the law is integrated implicitly.
Ingress::Refused Ingress::check_law(const PlaneSample& plane, std::size_t p) {
  constexpr auto kBad = IngressVerdict::kBadPlane;
  const bool law = plane.damping != 0.0 || plane.ground_stiffness != 0.0 || plane.load != 0.0;
  if (plane.mass == 0.0 && law) {
    return refused(kBad, "planes[{}].mass = 0: must be above 0 with damping, stiffness or load", p);
  }
  if (plane.mass > 0.0 && plane.id == 0) {
    return refused(kBad, "planes[{}].id = 0: must be given with a mass", p);
  }
  return check_object(plane, p);
}

Ingress::Refused Ingress::check_object(const PlaneSample& plane, std::size_t p) {
  constexpr auto kBad = IngressVerdict::kBadPlane;
  const auto& direction = plane.object_direction;
  if (plane.object == 0 && direction.count == 0) return {};
  if (plane.object == 0) {
    return refused(kBad, "planes[{}].object = 0: must be given with a direction", p);
  }
  if (plane.mass == 0.0) {
    return refused(kBad, "planes[{}].mass = 0: must be above 0 with an object", p);
  }
  if (direction.count == 0 || direction.count > core::kMaxMotions) {
    return refused(kBad, "planes[{}].object_direction has {} values: must have 1 to {}", p,
                   direction.count, core::kMaxMotions);
  }
  double square = 0.0;
  for (std::size_t i = 0; i < direction.count; ++i)
    square += direction.value[i] * direction.value[i];
  if (!(std::abs(std::sqrt(square) - 1.0) <= kOffUnit)) {
    return refused(kBad, "planes[{}].object_direction has length {:.9g}: must have length 1", p,
                   std::sqrt(square));
  }
  return {};
}

void Ingress::write_planes(const ProxySample& sample, core::ProxySnapshot& next) const {
  core::PlaneSet& planes = next.planes;
  const Eigen::Index count = sample.plane_count;
  bool pushed = false, shared = false;
  Eigen::Index curvatures = 0;
  next.anchored_at = 0;
  next.seen_at = sample.tick_used;
  planes.normals.resize(n_x_, count);
  planes.offsets.resize(count);
  planes.first = planes.curved = {};
  for (Eigen::Index p = 0; p < count; ++p) {
    const PlaneSample& plane = sample.planes[static_cast<std::size_t>(p)];
    std::transform(plane.normal.begin(), plane.normal.end(), planes.normals.col(p).data(), flushed);
    planes.offsets[p] = flushed(plane.offset);
    pushed = pushed || plane.mass > 0.0;
    shared = shared || plane.object != 0;
    curvatures += plane.curvature_count;
    if (plane.id != 0) next.anchored_at = sample.tick_used;
  }
  // A part that no plane of the sample has takes no room in the tick.
  write_fields(sample, planes);
  planes.laws.resize(Eigen::NoChange, pushed ? count : 0);
  planes.ids.resize(pushed ? count : 0);
  planes.objects.setZero(Eigen::NoChange, shared ? count : 0);
  planes.curvature.resize(curvatures);
  curvatures = 0;
  for (Eigen::Index p = 0; p < count; ++p) {
    const auto i = static_cast<std::size_t>(p);
    const PlaneSample& plane = sample.planes[i];
    if (pushed) {
      planes.laws.col(p) << plane.mass, plane.damping, plane.ground_stiffness, flushed(plane.load);
    }
    if (pushed) planes.ids[p] = plane.id;
    if (shared) planes.objects(0, p) = plane.object;
    for (std::uint32_t k = 0; shared && k < plane.object_direction.count; ++k) {
      planes.objects(1 + k, p) = flushed(plane.object_direction.value[k]);
    }
    const bool curves = plane.curvature_count > 0;  // else nothing bounds its first coordinate
    planes.first[i] = static_cast<std::uint8_t>(curves ? plane.first_coordinate : 0);
    planes.curved[i] = static_cast<std::uint8_t>(curved_coordinates(plane.curvature_count));
    for (std::uint32_t k = 0; k < plane.curvature_count; ++k) {
      planes.curvature[curvatures++] = flushed(plane.normal.value[n_x_ + k]);
    }
  }
}

}  // namespace haptic::server
