#include "soft_finger.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic::examples {

std::vector<client::Contact> SoftFinger::pads(const Joints& x, double horizon) const {
  const std::vector<double> at(x.begin(), x.end());
  std::vector<client::Contact> near;
  for (int i = 0; i < 2 * kPadsPerPhalanx; ++i) {
    const std::size_t phalanx = i < kPadsPerPhalanx ? 0 : 1;
    const double part = (i % kPadsPerPhalanx + 1.0) / kPadsPerPhalanx;
    client::Contact c;
    c.point = client::point_on_finger({model_.proximal}, at, phalanx,
                                      part * (phalanx == 0 ? model_.proximal : model_.distal),
                                      model_.pad_depth);
    const double rx = c.point.position[0] - model_.centre_x;
    const double ry = c.point.position[1] - model_.centre_y;
    const double distance = std::hypot(rx, ry);
    c.gap = distance - model_.radius;
    if (c.gap > horizon || distance == 0.0) continue;
    c.normal = {rx / distance, ry / distance, 0.0};
    c.curvature = client::cylinder_curvature(c.normal, {0.0, 0.0, 1.0}, distance);
    c.stiffness = model_.pad_stiffness;
    c.uncertainty = 0.0;
    c.id = static_cast<std::uint32_t>(i + 1);
    near.push_back(std::move(c));
  }
  return near;
}

std::vector<client::Plane> SoftFinger::contacts(const Joints& x, double horizon) const {
  std::vector<client::Plane> planes;
  for (const client::Contact& pad : pads(x, horizon)) {
    planes.push_back(client::contact_at({x.begin(), x.end()}, pad, model_.coupling));
  }
  return planes;
}

double SoftFinger::depth(const Joints& x) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const client::Contact& pad : pads(x, nearest)) nearest = std::min(nearest, pad.gap);
  return -nearest;
}

SoftFinger::Step SoftFinger::step(const Joints& x_probe) {
  const Joints from = probe_;
  const double far = std::max(std::abs(x_probe[0] - from[0]), std::abs(x_probe[1] - from[1]));
  const int pieces = std::max(1, static_cast<int>(std::ceil(std::min(far, kFarthest) / kPiece)));
  Step out;
  for (int i = 1; i <= pieces; ++i) {
    const double part = static_cast<double>(i) / pieces;
    out =
        follow({from[0] + part * (x_probe[0] - from[0]), from[1] + part * (x_probe[1] - from[1])});
  }
  return out;
}

SoftFinger::Step SoftFinger::follow(const Joints& x_probe) {
  probe_ = x_probe;
  // In contact from the last proxy, not from the probe: a probe pushed through the object and out
  // at its back must not count as free, nor draw the proxy after it.
  const Joints& start = touching_ ? last_ : x_probe;
  const auto near = [this](const std::vector<double>& x) { return pads({x[0], x[1]}, kNear); };
  const std::vector<double> x =
      client::solve(near, {x_probe.begin(), x_probe.end()}, model_.coupling,
                    {.start = {start.begin(), start.end()}})
          .x;
  touching_ = depth({x[0], x[1]}) > (touching_ ? -kRelease : 0.0);
  last_ = touching_ ? Joints{x[0], x[1]} : x_probe;
  return {touching_, last_};
}

}  // namespace haptic::examples
