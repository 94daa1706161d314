#include "tests/report/bound_bodies.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cstdint>

#include "haptic/client/contact.hpp"
#include "tests/report/rtt_object.hpp"

namespace haptic::report {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

/// How p moves if a joint at the origin turns.
Vector2d turned(const Vector2d& p) {
  return {p[1], -p[0]};
}

struct Distance {
  Vector2d normal;
  double from, gap;  ///< from: the centre
};
Distance distance(const BoundBody& body, const Vector2d& point, double t) {
  const Vector2d off = point - body.place(t);
  if (body.flat()) return {body.normal, 0.0, body.normal.dot(off)};
  const double from = off.norm();
  return {off / from, from, from - body.radius};
}

}  // namespace

std::size_t BoundWorld::points(const Minimum& x, std::array<Point, kPads.size()>& all) const {
  if (!finger) {
    all[0].at = x;
    return 1;
  }
  const Vector2d first(std::cos(x[0]), -std::sin(x[0]));
  const Vector2d second(std::cos(x[0] + x[1]), -std::sin(x[0] + x[1]));
  for (std::size_t k = 0; k < kPads.size(); ++k) {
    const Pad& pad = kPads[k];
    const Vector2d arm = pad.along * (pad.phalanx == 0 ? first : second);
    all[k] = {arm, Vector2d::Zero(), true};
    if (pad.phalanx == 1) all[k] = {kPhalanx * first + arm, arm, true};
  }
  return kPads.size();
}

std::size_t BoundWorld::gaps(double t, const Minimum& x,
                             std::array<BoundGap, kMostGaps>& all) const {
  std::array<Point, kPads.size()> at;
  const std::size_t count = points(x, at);
  std::size_t n = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const Point& point = at[k];
    Matrix2d J = Matrix2d::Identity();
    if (point.turns) J << turned(point.at), turned(point.arm);
    for (const BoundBody& body : bodies) {
      const auto [normal, from, phi] = distance(body, point.at, t);
      BoundGap& gap = all[n++];
      gap = {phi, coupling / body.stiffness, J.transpose() * normal};
      if (!body.flat()) {
        const Matrix2d bend = (Matrix2d::Identity() - normal * normal.transpose()) / from;
        gap.H = J.transpose() * bend * J;
      }
      if (!point.turns) continue;
      const double along = normal.dot(point.arm);
      gap.H -= (Matrix2d() << normal.dot(point.at), along, along, along).finished();
    }
  }
  return n;
}

double BoundWorld::cost(double t, const Minimum& p, const Minimum& x) const {
  std::array<Point, kPads.size()> at;
  const std::size_t count = points(x, at);
  double sum = 0.5 * (x - p).squaredNorm();
  for (std::size_t k = 0; k < count; ++k) {
    for (const BoundBody& body : bodies) {
      const double phi = distance(body, at[k].at, t).gap;
      if (phi < 0.0) sum += 0.5 * phi * phi * body.stiffness / coupling;
    }
  }
  return sum;
}

BoundWorld::Minimum BoundWorld::from(double t, const Minimum& p, const Minimum& start) const {
  Minimum x = start;
  double at = cost(t, p, x);
  std::array<BoundGap, kMostGaps> all;
  for (int i = 0; i < 200; ++i) {
    Vector2d slope = x - p;
    Matrix2d curve = Matrix2d::Identity();
    const std::size_t count = gaps(t, x, all);
    for (std::size_t k = 0; k < count; ++k) {
      const BoundGap& gap = all[k];
      if (gap.phi >= 0.0) continue;
      slope += gap.phi / gap.gamma * gap.g;
      curve += gap.g * gap.g.transpose() / gap.gamma + gap.phi / gap.gamma * gap.H;
    }
    Eigen::SelfAdjointEigenSolver<Matrix2d> of;
    of.computeDirect(curve);
    const Vector2d size = of.eigenvalues().cwiseAbs().cwiseMax(0.01);
    const Vector2d step =
        -of.eigenvectors() * (of.eigenvectors().transpose() * slope).cwiseQuotient(size);
    if (-slope.dot(step) < 1e-22) break;
    double share = 1.0;
    for (; share > 1e-9; share *= 0.5) {
      const Minimum there = x + share * step;
      const double then = cost(t, p, there);
      if (then > at + 1e-4 * share * slope.dot(step)) continue;
      at = then;
      x = there;
      break;
    }
    if (share <= 1e-9) break;
  }
  return x;
}

BoundWorld::Minimum BoundWorld::least(double t, const Minimum& p, const Minimum& last) const {
  Minimum best = from(t, p, last);
  if (finger) return best;
  double least = cost(t, p, best);
  const auto attempt = [&](const Minimum& start) {
    const Minimum x = from(t, p, start);
    const double at = cost(t, p, x);
    if (at >= least - 1e-15) return;
    least = at;
    best = x;
  };
  attempt(p);
  for (const BoundBody& body : bodies) {
    const Vector2d off = p - body.place(t);
    if (body.flat() || off.norm() >= body.radius) continue;
    for (const double turn : {0.0, 0.6, -0.6}) {
      const Vector2d way = Eigen::Rotation2Dd(turn) * off.normalized();
      attempt(body.place(t) + body.radius * way);
    }
  }
  return best;
}

std::vector<client::Plane> BoundWorld::told(double t, const core::VecX& x, double near,
                                            double uncertainty) const {
  std::vector<client::PointMap> points;
  if (!finger) points = {rtt_point_of(x)};
  for (std::size_t k = 0; finger && k < kPads.size(); ++k) {
    const Pad& pad = kPads[k];
    points.push_back(client::point_on_finger({kPhalanx, 0.03}, to_std(x), pad.phalanx, pad.along));
  }
  std::vector<client::Plane> planes;
  std::uint32_t id = 0;
  for (const client::PointMap& point : points) {
    for (const BoundBody& body : bodies) {
      ++id;
      const auto [n, from, gap] = distance(body, Vector2d(point.position[0], point.position[1]), t);
      if (gap > near) continue;
      client::Contact contact{.point = point,
                              .normal = {n[0], n[1], 0.0},
                              .gap = gap,
                              .stiffness = body.stiffness * body.told,
                              .velocity = -n.dot(body.velocity),
                              .id = id,
                              .uncertainty = uncertainty};
      if (!body.flat()) {
        contact.curvature = client::cylinder_curvature(contact.normal, {0.0, 0.0, 1.0}, from);
      }
      planes.push_back(client::contact_at(to_std(x), contact, coupling));
    }
  }
  return planes;
}

}  // namespace haptic::report
