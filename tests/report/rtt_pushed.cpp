// Objects of the study rtt that the finger pushes: rtt_object.hpp.
#include <algorithm>
#include <cmath>

#include "haptic/client/planes.hpp"
#include "tests/report/rtt_object.hpp"

namespace haptic::report {
namespace {

using client::Plane;
using core::VecX;

constexpr double kFelt = kRttSoft * kRttCoupling / (kRttSoft + kRttCoupling);  // N/m, both springs
constexpr double kTurn = 2.0 * M_PI * 0.5;  // rad/s, of a disturbance

/// N, of a finger that is `depth` beyond the surface.
double pushed(double depth) {
  return kFelt * std::max(depth, 0.0);
}

/// One coordinate s of an object, which the world moves by velocity Verlet in steps of 20 us,
/// another rule than the server's.
class Pushed : public RttObject {
 public:
  explicit Pushed(const RttPushed& what)
      : what_(what),
        damping_(what.damping > 0.0 ? what.damping : 0.6 * std::sqrt(what.mass * what.ground)) {}

  void advance(double t, const VecX& x_probe) override {
    constexpr int kSteps = 50;
    constexpr double dt = 1e-3 / kSteps;
    if (last_.size() == 0) last_ = x_probe;
    for (int i = 1; i <= kSteps; ++i) {
      const VecX probe = last_ + static_cast<double>(i) / kSteps * (x_probe - last_);
      const double half = v_ + 0.5 * dt * (push(t, probe) - damping_ * v_) / what_.mass;
      s_ += dt * half;
      v_ = (half + 0.5 * dt * push(t, probe) / what_.mass) /
           (1.0 + 0.5 * dt * damping_ / what_.mass);
    }
    last_ = x_probe;
  }

 protected:
  /// Force on the object at `t` s, but for its damping, N.
  [[nodiscard]] virtual double push(double t, const VecX& x_probe) = 0;

  RttPushed what_;
  double damping_;          // N s/m
  double s_{0.0}, v_{0.0};  // m, m/s
  VecX last_{};
};

class PushedMass : public Pushed {
 public:
  using Pushed::Pushed;

  [[nodiscard]] VecX proxy(double t, const VecX& x_probe) override {
    if (what_.own_steps) step(t, x_probe[0]);
    const double depth = x_probe[0] - s_;
    return depth > 0.0 ? VecX::Constant(1, s_ + rtt_share(depth, kRttSoft)) : x_probe;
  }
  [[nodiscard]] std::vector<Plane> contacts(double, const VecX& x,
                                            const RttHorizon& near) const override {
    if (s_ - x[0] > near.metres) return {};
    client::Contact c{.point = rtt_point_of(x),
                      .normal = {-1.0, 0.0, 0.0},
                      .gap = s_ - x[0],
                      .stiffness = kRttSoft,
                      .id = 1};
    if (what_.told != RttPushed::kSurface) c.velocity = v_;
    if (what_.told == RttPushed::kLaw) {
      c.mass = what_.told_mass * what_.mass;
      c.damping = damping_;
      c.ground_stiffness = what_.ground;
      c.load = load_;
    }
    return {client::contact_at(to_std(x), c, kRttCoupling)};
  }
  [[nodiscard]] double clearance(double, const VecX& x_probe) const override {
    return s_ - x_probe[0];
  }

 private:
  [[nodiscard]] double push(double t, const VecX& x_probe) override {
    load_ = what_.disturbance * std::sin(kTurn * t) - what_.ground * s_;
    return pushed(x_probe[0] - s_) + load_;
  }
  /// Steps as a simulation with a step per sample would: all forces as they were, then the place.
  void step(double t, double probe) {
    const double dt = last_.size() == 0 ? 0.0 : t - stepped_;
    load_ = -what_.ground * s_;
    v_ += dt * (pushed(probe - s_) + load_ - damping_ * v_) / what_.mass;
    s_ += dt * v_;
    load_ = -what_.ground * s_;
    stepped_ = t;
    last_ = VecX::Constant(1, probe);
  }

  double load_{0.0};     // N
  double stepped_{0.0};  // s
};

/// The block between two fingers, one per coordinate, on a damper.
class PushedBlock : public Pushed {
 public:
  using Pushed::Pushed;

  [[nodiscard]] VecX proxy(double, const VecX& x_probe) override {
    VecX x = x_probe;
    for (int i = 0; i < 2; ++i) {
      const double depth = -gap(i, x_probe);
      if (depth > 0.0) x[i] += side(i) * (depth - rtt_share(depth, kRttSoft));
    }
    return x;
  }
  /// Two contacts on one object, which damping alone holds.
  [[nodiscard]] std::vector<Plane> contacts(double, const VecX& x,
                                            const RttHorizon& near) const override {
    std::vector<Plane> all;
    for (int i = 0; i < 2; ++i) {
      if (gap(i, x) > near.metres) continue;
      Plane plane =
          client::contact(to_std(x), gap(i, x), {i == 0 ? side(0) : 0.0, i == 1 ? side(1) : 0.0});
      plane.compliance = kRttCoupling / kRttSoft;
      plane.velocity = -side(i) * v_;
      plane.mass = what_.mass / kRttCoupling;
      plane.damping = damping_ / kRttCoupling;
      plane.id = static_cast<std::uint32_t>(i + 1);
      plane.object = 1;
      plane.object_direction = {side(i)};
      all.push_back(plane);
    }
    return all;
  }
  [[nodiscard]] double clearance(double, const VecX& x_probe) const override {
    return std::min(gap(0, x_probe), gap(1, x_probe));
  }

 private:
  static constexpr double kHalf = 0.020;  // m, of the block's width

  /// Towards finger i along its coordinate.
  static double side(int i) { return i == 0 ? -1.0 : 1.0; }
  [[nodiscard]] double gap(int i, const VecX& x) const { return side(i) * (x[i] - s_) - kHalf; }
  [[nodiscard]] double push(double, const VecX& x_probe) override {
    return pushed(-gap(0, x_probe)) - pushed(-gap(1, x_probe));
  }
};

}  // namespace

std::unique_ptr<RttObject> rtt_pushed(const RttPushed& what) {
  return std::make_unique<PushedMass>(what);
}
std::unique_ptr<RttObject> rtt_pushed_block(const RttPushed& what) {
  return std::make_unique<PushedBlock>(what);
}

}  // namespace haptic::report
