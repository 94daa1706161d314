#include "haptic/client/planes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic::client {

namespace {

constexpr double kPi = 3.14159265358979323846;

/// Coordinate i of x_probe (-) x: an angle the short way round, a quaternion with the sign that is
/// nearer to x.
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

}  // namespace

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
  if (planes.size() <= kMaxPlanes) return 0;
  const std::size_t n_x = coordinates.size(), left_out = planes.size() - kMaxPlanes;
  const auto depth = [&](const Plane& plane) {
    double out = -plane.offset, length = 0.0;
    for (std::size_t i = 0; i < n_x; ++i) {
      out += plane.normal[i] * (x[i] + difference(coordinates, x_probe, x, i));
      length = std::hypot(length, plane.normal[i]);
    }
    return length > 0.0 ? out / length : -std::numeric_limits<double>::infinity();
  };
  const auto fits = [&](const Plane& plane) { return plane.normal.size() == n_x; };
  if (x.size() == n_x && x_probe.size() == n_x && std::all_of(planes.begin(), planes.end(), fits)) {
    std::vector<double> depths;
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < planes.size(); ++i) {
      depths.push_back(depth(planes[i]));
      chosen.push_back(i);
    }
    std::stable_sort(chosen.begin(), chosen.end(),
                     [&](std::size_t a, std::size_t b) { return depths[a] > depths[b]; });
    std::sort(chosen.begin(), chosen.begin() + kMaxPlanes);
    for (std::size_t k = 0; k < kMaxPlanes; ++k) {
      if (chosen[k] != k) planes[k] = std::move(planes[chosen[k]]);
    }
  }
  planes.resize(kMaxPlanes);
  return left_out;
}

}  // namespace haptic::client
