#include "haptic/client/estimator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "difference.hpp"

namespace haptic::client {

namespace {

constexpr std::size_t kSamples = 8;
constexpr double kStill = 0.04;  // of kMotion: less is no motion back

}  // namespace

ContactEstimator::ContactEstimator(std::vector<VirtualCoordinate> coordinates,
                                   std::vector<Block> blocks)
    : coordinates_(std::move(coordinates)) {
  if (blocks.empty()) blocks.push_back({0, coordinates_.size()});
  for (const Block& block : blocks) estimates_.push_back({block, {}, 0.0});
}

std::vector<Plane> ContactEstimator::contacts(const std::vector<double>& x,
                                              const std::vector<double>& x_probe) {
  std::vector<Plane> contacts;
  for (std::size_t b = 0; b < estimates_.size(); ++b) {
    Estimate& block = estimates_[b];
    const auto planes = derive_planes(coordinates_, x, x_probe, {block.block});
    if (planes.empty()) {
      block.samples.clear();
      continue;
    }
    Plane contact = planes.front();
    block.samples.push_back({x, x_probe});
    if (block.samples.size() > kSamples) block.samples.pop_front();
    estimate(block, contact.normal);
    // The surface is where the probe would be without force: the gap at x is -compliance times the
    // proxy's distance from the probe.
    double distance = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      distance += contact.normal[i] * difference(coordinates_, x_probe, x, i);
    }
    contact.compliance = block.follows / (1.0 - block.follows);
    contact.offset -= contact.compliance * distance;
    contact.id = static_cast<std::uint32_t>(b + 1);
    contacts.push_back(std::move(contact));
  }
  return contacts;
}

void ContactEstimator::free() noexcept {
  for (Estimate& block : estimates_) block.samples.clear();
}

void ContactEstimator::estimate(Estimate& block, const std::vector<double>& normal) const {
  const std::size_t end = block.block.first + block.block.count;
  double motion = kMotionMetres;
  for (std::size_t i = block.block.first; i < end; ++i) {
    if (coordinates_[i].unit == "rad") motion = kMotionRadians;
  }
  // Along the normal, from the newest sample back, as long as the probe came one way.
  const Sample& newest = block.samples.back();
  std::vector<double> p, x;
  double way = 0.0;
  for (auto sample = block.samples.rbegin(); sample != block.samples.rend(); ++sample) {
    double p_k = 0.0, x_k = 0.0;
    for (std::size_t i = block.block.first; i < end; ++i) {
      p_k += normal[i] * difference(coordinates_, sample->x_probe, newest.x_probe, i);
      x_k += normal[i] * difference(coordinates_, sample->x, newest.x, i);
    }
    const double step = p.empty() ? 0.0 : p_k - p.back();
    if (way == 0.0 && std::abs(step) > kStill * motion) way = step;
    if (way * step < 0.0 && std::abs(step) > kStill * motion) break;
    p.push_back(p_k);
    x.push_back(x_k);
  }
  const auto n = static_cast<double>(p.size());
  if (p.size() < 3 || std::abs(p.back()) < motion) return;
  double mean_p = 0.0, mean_x = 0.0, pp = 0.0, px = 0.0, rest = 0.0;
  for (std::size_t k = 0; k < p.size(); ++k) {
    mean_p += p[k] / n;
    mean_x += x[k] / n;
  }
  for (std::size_t k = 0; k < p.size(); ++k) {
    pp += (p[k] - mean_p) * (p[k] - mean_p);
    px += (p[k] - mean_p) * (x[k] - mean_x);
  }
  const double slope = px / pp;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const double off = x[k] - mean_x - slope * (p[k] - mean_p);
    rest += off * off;
  }
  const double standard_error = std::sqrt(rest / (n - 2.0) / pp);
  if (std::isfinite(slope)) block.follows = std::clamp(slope - standard_error, 0.0, kSoftest);
}

}  // namespace haptic::client
