#include "haptic/client/planes.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::client {

namespace {

constexpr std::size_t kMaxPlanes = 6;  // proto/README.md
constexpr double kPi = 3.14159265358979323846;

struct Candidate {
  double distance{0.0};
  Plane plane{};
};

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

std::vector<Plane> derive_planes(const std::vector<VirtualCoordinate>& coordinates,
                                 const std::vector<double>& x, const std::vector<double>& x_probe,
                                 const std::vector<Block>& blocks, double least) {
  const std::size_t n_x = coordinates.size();
  if (x.size() != n_x || x_probe.size() != n_x) return {};
  const std::vector<Block> whole{{0, n_x}};
  std::vector<Candidate> found;
  for (const Block& block : blocks.empty() ? whole : blocks) {
    if (block.first > n_x || block.count > n_x - block.first) continue;
    Candidate candidate;
    candidate.plane.normal.assign(n_x, 0.0);
    for (std::size_t i = block.first; i < block.first + block.count; ++i) {
      const double away = difference(coordinates, x_probe, x, i);
      candidate.plane.normal[i] = away;
      candidate.distance = std::hypot(candidate.distance, away);
    }
    if (!(candidate.distance > least)) continue;
    for (std::size_t i = block.first; i < block.first + block.count; ++i) {
      candidate.plane.normal[i] /= candidate.distance;
      candidate.plane.offset += candidate.plane.normal[i] * x[i];
    }
    found.push_back(std::move(candidate));
  }
  if (found.size() > kMaxPlanes) {
    std::stable_sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
      return a.distance > b.distance;
    });
    found.resize(kMaxPlanes);
  }
  std::vector<Plane> planes;
  planes.reserve(found.size());
  for (Candidate& candidate : found) planes.push_back(std::move(candidate.plane));
  return planes;
}

}  // namespace haptic::client
