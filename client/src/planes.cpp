#include "haptic/client/planes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "difference.hpp"

namespace haptic::client {

namespace {

constexpr double kPi = 3.14159265358979323846;

bool is_contact(const Plane& plane) {
  return plane.compliance > 0.0 || !plane.curvature.empty() || plane.id != 0;
}

bool share_coordinate(const Plane& a, const Plane& b) {
  for (std::size_t i = 0; i < a.normal.size(); ++i) {
    if (a.normal[i] != 0.0 && b.normal[i] != 0.0) return true;
  }
  return false;
}

}  // namespace

double difference(const std::vector<VirtualCoordinate>& coordinates,
                  const std::vector<double>& x_probe, const std::vector<double>& x, std::size_t i) {
  const std::string& kind = coordinates[i].kind;
  if (kind == "angle") return std::remainder(x_probe[i] - x[i], 2.0 * kPi);
  if (kind != "quaternion") return x_probe[i] - x[i];
  // Four parts in a row: the first of them is as many whole quaternions after the run's begin.
  std::size_t begin = i;
  while (begin > 0 && coordinates[begin - 1].kind == "quaternion") --begin;
  begin = i - (i - begin) % 4;
  double same = 0.0;
  for (std::size_t k = begin; k < std::min(begin + 4, x.size()); ++k) same += x_probe[k] * x[k];
  return (same < 0.0 ? -x_probe[i] : x_probe[i]) - x[i];
}

Plane contact(const std::vector<double>& x, double gap, const std::vector<double>& gradient) {
  Plane plane;
  plane.offset = gap;
  for (std::size_t i = 0; i < std::min(x.size(), gradient.size()); ++i) {
    plane.normal.push_back(-gradient[i]);
    plane.offset -= gradient[i] * x[i];
  }
  return plane;
}

std::vector<Plane> derive_planes(const std::vector<VirtualCoordinate>& coordinates,
                                 const std::vector<double>& x, const std::vector<double>& x_probe,
                                 const std::vector<Block>& blocks, double least) {
  const std::size_t n_x = coordinates.size();
  if (x.size() != n_x || x_probe.size() != n_x) return {};
  const std::vector<Block> whole{{0, n_x}};
  std::vector<Plane> planes;
  for (const Block& block : blocks.empty() ? whole : blocks) {
    if (block.first > n_x || block.count > n_x - block.first) continue;
    Plane plane;
    plane.normal.assign(n_x, 0.0);
    double distance = 0.0;
    for (std::size_t i = block.first; i < block.first + block.count; ++i) {
      const double away = difference(coordinates, x_probe, x, i);
      plane.normal[i] = away;
      distance = std::hypot(distance, away);
    }
    if (!(distance > least)) continue;
    for (std::size_t i = block.first; i < block.first + block.count; ++i) {
      plane.normal[i] /= distance;
      plane.offset += plane.normal[i] * x[i];
    }
    planes.push_back(std::move(plane));
  }
  return planes;
}

std::size_t keep_deepest(const std::vector<VirtualCoordinate>& coordinates,
                         const std::vector<double>& x, const std::vector<double>& x_probe,
                         std::vector<Plane>& planes) {
  const std::size_t n_x = coordinates.size(), told = planes.size();
  const auto fits = [&](const Plane& plane) { return plane.normal.size() == n_x; };
  if (x.size() != n_x || !std::all_of(planes.begin(), planes.end(), fits)) {
    planes.resize(std::min(told, kMaxPlanes));
    return told - planes.size();
  }
  std::vector<double> probe = x, depths;
  for (std::size_t i = 0; i < n_x && x_probe.size() == n_x; ++i)
    probe[i] += difference(coordinates, x_probe, x, i);
  for (const Plane& plane : planes) {
    double out = -plane.offset, length = 0.0;
    for (std::size_t i = 0; i < n_x; ++i) {
      out += plane.normal[i] * probe[i];
      length = std::hypot(length, plane.normal[i]);
    }
    // A depth that is no number is farthest: the server refuses it, and no order holds with it.
    const bool known = length > 0.0 && std::isfinite(out);
    depths.push_back(known ? out / length : -std::numeric_limits<double>::infinity());
  }
  std::vector<std::size_t> order(told), chosen;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return depths[a] > depths[b]; });
  std::size_t curvatures = 0;
  for (const std::size_t i : order) {
    Plane& plane = planes[i];
    const auto neighbours = std::count_if(chosen.begin(), chosen.end(), [&](std::size_t other) {
      return is_contact(planes[other]) && share_coordinate(planes[other], plane);
    });
    const bool crowded = is_contact(plane) && neighbours >= std::ptrdiff_t{kMaxContactsOfBlock};
    if (chosen.size() == kMaxPlanes || crowded) continue;
    chosen.push_back(i);
    if (curvatures + plane.curvature.size() > kMaxCurvatures ||
        n_x + plane.curvature.size() > kMaxNumbersOfPlane) {
      plane.curvature.clear();
      plane.uncertainty.reset();  // it is told as flat, which it is not
    }
    curvatures += plane.curvature.size();
  }
  std::sort(chosen.begin(), chosen.end());
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (chosen[k] != k) planes[k] = std::move(planes[chosen[k]]);
  }
  planes.resize(chosen.size());
  return told - planes.size();
}

}  // namespace haptic::client
