#include "soft_finger.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::examples {

namespace {

struct Pad {
  double x, y;          // position
  double dx[2], dy[2];  // derivatives by q1, q2
};

/// Pad `i` of 2 * kPadsPerPhalanx at joints q.
Pad pad(const SoftFingerModel& m, const Joints& q, int i) {
  const int per = SoftFinger::kPadsPerPhalanx;
  const bool distal = i >= per;
  const double along = (i % per + 1.0) / per * (distal ? m.distal : m.proximal);
  const double c1 = std::cos(q[0]), s1 = std::sin(q[0]);
  const double a = distal ? q[0] + q[1] : q[0];
  const double c = std::cos(a), s = std::sin(a);
  const double base_x = distal ? m.proximal * c1 : 0.0;
  const double base_y = distal ? -m.proximal * s1 : 0.0;
  // Along the phalanx (c, -s), then to the palmar side (-s, -c).
  const double rel_x = along * c - m.pad_depth * s;
  const double rel_y = -along * s - m.pad_depth * c;
  Pad p{base_x + rel_x, base_y + rel_y, {}, {}};
  // Flexion turns by -90 degrees times the rate: d(x, y) = (y, -x) dq about the joint.
  p.dx[0] = p.y;
  p.dy[0] = -p.x;
  p.dx[1] = distal ? rel_y : 0.0;
  p.dy[1] = distal ? -rel_x : 0.0;
  return p;
}

}  // namespace

SoftFinger::Energy SoftFinger::contact(const Joints& x) const {
  Energy e;
  for (int i = 0; i < 2 * kPadsPerPhalanx; ++i) {
    const Pad p = pad(model_, x, i);
    const double rx = p.x - model_.centre_x, ry = p.y - model_.centre_y;
    const double distance = std::hypot(rx, ry);
    const double inside = model_.radius - distance;
    e.depth = std::max(e.depth, inside);
    if (inside <= 0.0 || distance == 0.0) continue;
    double slope[2];  // d inside / dq
    for (int k = 0; k < 2; ++k) slope[k] = -(rx * p.dx[k] + ry * p.dy[k]) / distance;
    const double k = model_.pad_stiffness;
    e.value += 0.5 * k * inside * inside;
    e.gradient[0] += k * inside * slope[0];
    e.gradient[1] += k * inside * slope[1];
    e.hessian[0] += k * slope[0] * slope[0];
    e.hessian[1] += k * slope[0] * slope[1];
    e.hessian[2] += k * slope[1] * slope[1];
  }
  return e;
}

std::vector<client::Plane> SoftFinger::contacts(const Joints& x, double horizon) const {
  const std::vector<double> at(x.begin(), x.end());
  std::vector<client::Plane> planes;
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
    planes.push_back(client::contact_at(at, c, model_.coupling));
  }
  return planes;
}

double SoftFinger::total(const Joints& x, const Joints& x_probe) const {
  const double d1 = x[0] - x_probe[0], d2 = x[1] - x_probe[1];
  return 0.5 * model_.coupling * (d1 * d1 + d2 * d2) + contact(x).value;
}

/// Gauss-Newton with halving: the energy never rises.
Joints SoftFinger::minimise(const Joints& x_probe, const Joints& seed) const {
  constexpr int kSteps = 25, kHalvings = 12;
  Joints x = seed;
  double energy = total(x, x_probe);
  for (int i = 0; i < kSteps; ++i) {
    const Energy c = contact(x);
    const double g1 = c.gradient[0] + model_.coupling * (x[0] - x_probe[0]);
    const double g2 = c.gradient[1] + model_.coupling * (x[1] - x_probe[1]);
    const double a = c.hessian[0] + model_.coupling, b = c.hessian[1];
    const double d = c.hessian[2] + model_.coupling;
    const double det = a * d - b * b;  // >= coupling^2
    Joints move{-(d * g1 - b * g2) / det, -(a * g2 - b * g1) / det};
    bool moved = false;
    for (int h = 0; h < kHalvings && !moved; ++h) {
      const Joints trial{x[0] + move[0], x[1] + move[1]};
      const double trial_energy = total(trial, x_probe);
      if (trial_energy < energy) {
        x = trial;
        energy = trial_energy;
        moved = true;
      }
      if (!moved) move = {0.5 * move[0], 0.5 * move[1]};
    }
    if (!moved || std::hypot(move[0], move[1]) < 1e-9) break;
  }
  return x;
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
  const Joints x = touching_ ? minimise(x_probe, last_) : minimise(x_probe, x_probe);
  const Energy here = contact(x);
  touching_ = here.depth > (touching_ ? -kRelease : 0.0);
  Step out;
  out.touching = touching_;
  out.x = touching_ ? x : x_probe;
  out.energy = touching_ ? here.value : 0.0;
  last_ = out.x;
  return out;
}

}  // namespace haptic::examples
