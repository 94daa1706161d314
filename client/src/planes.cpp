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
      double away = x_probe[i] - x[i];
      if (coordinates[i].kind == "angle") away = std::remainder(away, 2.0 * kPi);
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
  for (Candidate& candidate : found) planes.push_back(std::move(candidate.plane));
  return planes;
}

}  // namespace haptic::client
