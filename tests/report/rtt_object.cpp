#include "tests/report/rtt_object.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "haptic/client/planes.hpp"
#include "soft_finger.hpp"

namespace haptic::report {
namespace {

using client::Plane;
using core::VecX;

constexpr double kRigid = std::numeric_limits<double>::infinity();

class Wall : public RttObject {
 public:
  explicit Wall(double stiffness, bool moves = false) : stiffness_(stiffness), moves_(moves) {}

  [[nodiscard]] VecX proxy(double t, const VecX& x_probe) override {
    const double depth = x_probe[0] - surface(t);
    return depth > 0.0 ? VecX::Constant(1, surface(t) + share(depth)) : x_probe;
  }
  [[nodiscard]] std::vector<Plane> contacts(double t, const VecX& x,
                                            const RttHorizon& near) const override {
    const double gap = surface(t) - x[0];
    return gap <= near.metres ? springs({t, near.seconds}, x, gap) : std::vector<Plane>{};
  }
  [[nodiscard]] double clearance(double t, const VecX& x_probe) const override {
    return surface(t) - x_probe[0];
  }

 protected:
  struct Span {
    double from{0.0}, length{0.0};  // s
  };
  /// Depth of the proxy.
  [[nodiscard]] virtual double share(double depth) const {
    return std::isinf(stiffness_) ? 0.0 : rtt_share(depth, stiffness_);
  }
  [[nodiscard]] virtual std::vector<Plane> springs(const Span& at, const VecX& x,
                                                   double gap) const {
    // A surface that accelerates moves otherwise than told: nothing is promised.
    return {spring(at, x, gap, stiffness_, 1, moves_ ? std::nullopt : std::optional(0.0))};
  }
  [[nodiscard]] Plane spring(const Span& at, const VecX& x, double gap, double stiffness,
                             std::uint32_t id, std::optional<double> uncertainty) const {
    return client::contact_at(
        to_std(x),
        {.point = rtt_point_of(x),
         .normal = {-1.0, 0.0, 0.0},
         .gap = gap,
         .stiffness = stiffness,
         .velocity = (surface(at.from + at.length) - surface(at.from)) / at.length,
         .id = id,
         .uncertainty = uncertainty},
        kRttCoupling);
  }

 private:
  static constexpr double kWay = 0.005, kTurn = 2.0 * M_PI * 0.5;  // m, rad/s
  [[nodiscard]] double surface(double t) const { return moves_ ? kWay * std::sin(kTurn * t) : 0.0; }

  double stiffness_;
  bool moves_;
};

class StiffeningWall : public Wall {
 public:
  explicit StiffeningWall(bool as_springs) : Wall(kRigid), as_springs_(as_springs) {}

 private:
  static constexpr double kLaw = 5000.0;     // N/m^1.5
  static constexpr double kAtLeast = 0.003;  // m
  static constexpr double kDeepest = 0.022;  // m

  static double force(double depth) { return kLaw * depth * std::sqrt(depth); }
  /// Difference that the stiffness from `depth` to any other one may have from the told one.
  static double uncertainty(double depth, double told) {
    const double least = kLaw * std::sqrt(depth);
    const double most = (force(kDeepest) - force(depth)) / (kDeepest - depth);
    return std::max(1.0 - least / told, most / told - 1.0);
  }
  /// K (depth - d) = a d^1.5, by Newton from above: the residual is convex in d.
  [[nodiscard]] double share(double depth) const override {
    double d = depth;
    for (int i = 0; i < 50; ++i) {
      const double off = force(d) - kRttCoupling * (depth - d);
      d -= off / (1.5 * kLaw * std::sqrt(d) + kRttCoupling);
    }
    return d;
  }
  [[nodiscard]] std::vector<Plane> springs(const Span& at, const VecX& x,
                                           double gap) const override {
    if (!as_springs_) {
      const double told = 1.5 * kLaw * std::sqrt(std::max(-gap, kAtLeast));
      return {spring(at, x, gap, told, 1, uncertainty(std::max(-gap, 0.0), told))};
    }
    // The chords of the law between these depths: each spring adds what its chord is steeper.
    static constexpr double kDepths[]{0.0, 0.0008, 0.0025, 0.005, 0.009, 0.014, 0.022};
    std::vector<Plane> all;
    double steepness = 0.0;
    for (std::uint32_t i = 0; i + 1 < std::size(kDepths); ++i) {
      const double chord =
          (force(kDepths[i + 1]) - force(kDepths[i])) / (kDepths[i + 1] - kDepths[i]);
      // No chord is off by more than the first one's own stiffness.
      all.push_back(spring(at, x, gap + kDepths[i], chord - steepness, i + 1, i == 0 ? 1.0 : 0.0));
      steepness = chord;
    }
    return all;
  }

  bool as_springs_;
};

class Disc : public RttObject {
 public:
  [[nodiscard]] VecX proxy(double, const VecX& x_probe) override {
    const VecX out = from_centre(x_probe);
    const double depth = kRadius - out.norm();
    if (!(depth > 0.0)) return x_probe;
    return x_probe + (depth - rtt_share(depth, kRttSoft)) * out.normalized();
  }
  [[nodiscard]] std::vector<Plane> contacts(double t, const VecX& x,
                                            const RttHorizon& near) const override {
    if (clearance(t, x) > near.metres) return {};
    const VecX out = from_centre(x);
    const double distance = out.norm();
    client::Contact c{.point = rtt_point_of(x),
                      .normal = {out[0] / distance, out[1] / distance, 0.0},
                      .gap = distance - kRadius,
                      .stiffness = kRttSoft,
                      .id = 1,
                      .uncertainty = 0.0};
    c.curvature = client::cylinder_curvature(c.normal, {0.0, 0.0, 1.0}, distance);
    return {client::contact_at(to_std(x), c, kRttCoupling)};
  }
  [[nodiscard]] double clearance(double, const VecX& x_probe) const override {
    return from_centre(x_probe).norm() - kRadius;
  }

 private:
  static constexpr double kRadius = 0.030;  // m
  [[nodiscard]] static VecX from_centre(const VecX& x) {
    VecX out = x;
    out[1] += kRadius;
    return out;
  }
};

class Block : public RttObject {
 public:
  [[nodiscard]] VecX proxy(double, const VecX& x_probe) override {
    const double over = -clearance(0.0, x_probe);
    if (!(over > 0.0)) return x_probe;
    const double way =
        over * kRttSoft / (kRttCoupling + 2.0 * kRttSoft);  // K way = k (over - 2 way)
    return x_probe + (VecX(2) << -way, way).finished();
  }
  [[nodiscard]] std::vector<Plane> contacts(double t, const VecX& x,
                                            const RttHorizon& near) const override {
    if (clearance(t, x) > near.metres) return {};
    Plane plane = client::contact(to_std(x), clearance(t, x), {-1.0, 1.0});
    plane.compliance = kRttCoupling / kRttSoft;
    plane.id = 1;
    plane.uncertainty = 0.0;
    return {plane};
  }
  [[nodiscard]] double clearance(double, const VecX& x_probe) const override {
    return x_probe[1] - x_probe[0] - kWidth;
  }

 private:
  static constexpr double kWidth = 0.040;  // m
};

class Grasp : public RttObject {
 public:
  [[nodiscard]] VecX proxy(double, const VecX& x_probe) override {
    const examples::SoftFinger::Step step = finger_.step({x_probe[0], x_probe[1]});
    return (VecX(2) << step.x[0], step.x[1]).finished();
  }
  [[nodiscard]] std::vector<Plane> contacts(double, const VecX& x,
                                            const RttHorizon& near) const override {
    return finger_.contacts({x[0], x[1]}, near.metres);
  }
  [[nodiscard]] double clearance(double, const VecX& x_probe) const override {
    return -finger_.depth({x_probe[0], x_probe[1]});
  }

 private:
  examples::SoftFinger finger_{};
};

}  // namespace

double rtt_share(double depth, double k) {
  return depth > 0.0 ? depth * kRttCoupling / (kRttCoupling + k) : depth;
}

client::PointMap rtt_point_of(const VecX& x) {
  client::PointMap map;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    map.position[k] = x[i];
    client::Vector3 column{};
    column[k] = 1.0;
    map.jacobian.push_back(column);
  }
  return map;
}

std::vector<double> to_std(const VecX& x) {
  return {x.data(), x.data() + x.size()};
}

std::unique_ptr<RttObject> rtt_rigid_wall() {
  return std::make_unique<Wall>(kRigid);
}
std::unique_ptr<RttObject> rtt_soft_wall() {
  return std::make_unique<Wall>(kRttSoft);
}
std::unique_ptr<RttObject> rtt_stiffening_wall() {
  return std::make_unique<StiffeningWall>(false);
}
std::unique_ptr<RttObject> rtt_stiffening_springs() {
  return std::make_unique<StiffeningWall>(true);
}
std::unique_ptr<RttObject> rtt_moving_rigid_wall() {
  return std::make_unique<Wall>(kRigid, true);
}
std::unique_ptr<RttObject> rtt_moving_soft_wall() {
  return std::make_unique<Wall>(kRttSoft, true);
}
std::unique_ptr<RttObject> rtt_disc() {
  return std::make_unique<Disc>();
}
std::unique_ptr<RttObject> rtt_block() {
  return std::make_unique<Block>();
}
std::unique_ptr<RttObject> rtt_soft_finger() {
  return std::make_unique<Grasp>();
}

}  // namespace haptic::report
