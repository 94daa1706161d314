#include "haptic/core/model/finger_exoskeleton.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "drawing_parts.hpp"
#include "finger_linkage.hpp"
#include "finger_reach.hpp"
#include "haptic/core/error.hpp"

namespace haptic::core {

namespace {

std::string field(const char* name) {
  return std::string("finger_exoskeleton.") + name;
}

void require_positive(double value, const char* name) {
  require(value > 0.0, field(name), value, "> 0");
}

void require_finite(double value, const char* name) {
  require(true, field(name), value);
}

void require_range(double lower, double upper, const char* name) {
  if (!(std::isfinite(lower) && std::isfinite(upper) && lower < upper)) {
    throw SceneError(field(name) + " from " + std::to_string(lower) + " to " +
                     std::to_string(upper) + ": both must be finite, lower < upper");
  }
}

const FingerDimensions& checked(const FingerDimensions& d) {
  require_positive(d.proximal_phalanx, "proximal_phalanx_m");
  require_finite(d.rail_origin.x, "rail_origin_x_m");
  require_finite(d.rail_origin.y, "rail_origin_y_m");
  require_finite(d.rail_angle, "rail_angle_rad");
  require_finite(d.body_d.x, "body_d_x_m");
  require_finite(d.body_d.y, "body_d_y_m");
  require_finite(d.body_e.x, "body_e_x_m");
  require_finite(d.body_e.y, "body_e_y_m");
  require_positive(d.rod1, "rod1_m");
  require_positive(d.rod2, "rod2_m");
  require_positive(d.slider1_lower, "slider1_lower_m");
  require_positive(d.slider2_lower, "slider2_lower_m");
  require_range(d.slider1_lower, d.slider1_upper, "slider1");
  require_range(d.slider2_lower, d.slider2_upper, "slider2");
  require_range(d.l_x_lower, d.l_x_upper, "l_x");
  require_range(d.q_B_lower, d.q_B_upper, "q_B");
  return d;
}

class FingerExoskeleton final : public Kinematics {
 public:
  explicit FingerExoskeleton(const FingerDimensions& d)
      : Kinematics({{"l_x", Unit::kMetre, true, d.l_x_lower, d.l_x_upper},
                    {"q_B", Unit::kRadian, false, d.q_B_lower, d.q_B_upper}},
                   ConfigurationSpace(
                       {{"q_o1_mcp", Unit::kRadian, CoordinateKind::kLinear, d.proximal_phalanx},
                        {"q_o2_pip", Unit::kRadian, CoordinateKind::kLinear}})),
        linkage_(checked(d)),
        reach_(linkage_) {
    mean_J_a_ = reach_.mean_actuated_jacobian();
  }

  MapStatus evaluate(const VecQ& q, VecX& x_probe, MatXQ& J) const noexcept override {
    LinkagePose p;
    if (!linkage_.pose(q[0], q[1], p)) return MapStatus::kCannotClose;
    x_probe.resize(2);
    x_probe[0] = p.q1;
    x_probe[1] = p.q2;
    J.resize(2, 2);
    for (int k = 0; k < 2; ++k) {
      J(0, k) = p.J(0, k);
      J(1, k) = p.J(1, k);
    }
    return MapStatus::kOk;
  }

  MapStatus position(const VecQ& q, VecX& x_probe) const noexcept override {
    double q1 = 0.0, q2 = 0.0;
    if (!linkage_.joints(q[0], q[1], q1, q2)) return MapStatus::kCannotClose;
    x_probe.resize(2);
    x_probe[0] = q1;
    x_probe[1] = q2;
    return MapStatus::kOk;
  }

  MapStatus second_order(const VecQ& q, int k, MatXQ& J_k) const noexcept override {
    LinkageHessian h;
    if (!linkage_.hessian(q[0], q[1], h)) return MapStatus::kCannotClose;
    J_k.resize(2, 2);
    for (int i = 0; i < 2; ++i) {
      for (int m = 0; m < 2; ++m) J_k(i, m) = h.H[i][k][m];
    }
    return MapStatus::kOk;
  }

  MapStatus velocity_product(const VecQ& q, const VecQ& q_dot, VecX& out) const noexcept override {
    double product[2];
    if (!linkage_.velocity_product(q[0], q[1], q_dot[0], q_dot[1], product)) {
      return MapStatus::kCannotClose;
    }
    out.resize(2);
    out << product[0], product[1];
    return MapStatus::kOk;
  }

  InverseStatus inverse(const VecX& x, VecQ& q) const noexcept override {
    if (inverse_inside(x, q) == InverseStatus::kExact) return InverseStatus::kExact;
    q.resize(2);
    const ReachPoint nearest = reach_.nearest(x[0], x[1]);
    q[0] = nearest.l;
    q[1] = nearest.t;
    return InverseStatus::kUnreachable;
  }

  InverseStatus inverse_inside(const VecX& x, VecQ& q) const noexcept override {
    ClosedPose closed;
    if (!linkage_.closed_inverse(x[0], x[1], closed) || !acceptable(x[0], x[1], closed)) {
      return InverseStatus::kUnreachable;
    }
    q.resize(2);
    q[0] = closed.l;
    q[1] = closed.t;
    return InverseStatus::kExact;
  }

  InverseStatus follow(const Eigen::Vector2d& x, const Eigen::Vector2d& x_dot,
                       Followed& out) const noexcept override {
    ClosedPose closed;
    LinkageMotion motion;
    if (!linkage_.closed_motion(x[0], x[1], x_dot[0], x_dot[1], closed, motion) ||
        !acceptable(x[0], x[1], closed)) {
      return InverseStatus::kUnreachable;
    }
    out.q << closed.l, closed.t;
    out.J << motion.J[0][0], motion.J[0][1], motion.J[1][0], motion.J[1][1];
    out.product << motion.product[0], motion.product[1];
    return InverseStatus::kExact;
  }

  std::span<const int> limited_pairs() const noexcept override { return pair_; }
  MapStatus pair_limits(int, double a, double b, PairLimits& limits) const noexcept override {
    return reach_.limits(a, b, limits) ? MapStatus::kOk : MapStatus::kCannotClose;
  }
  Drawing drawing() const override { return finger_drawing(linkage_.dimensions()); }

 private:
  static constexpr int pair_[] = {0};
  /// Box and slider limits (the latter exclude rods on the far side of their joints), and angles
  /// that are not a turn away from what the linkage assembles to.
  [[nodiscard]] bool acceptable(double q1, double q2, const ClosedPose& p) const noexcept {
    const FingerDimensions& d = linkage_.dimensions();
    return p.l >= d.l_x_lower - FingerLinkage::kLimitSlack &&
           p.l <= d.l_x_upper + FingerLinkage::kLimitSlack &&
           p.t >= d.q_B_lower - FingerLinkage::kLimitSlack &&
           p.t <= d.q_B_upper + FingerLinkage::kLimitSlack &&
           p.c1 >= d.slider1_lower - FingerLinkage::kLimitSlack &&
           p.c1 <= d.slider1_upper + FingerLinkage::kLimitSlack &&
           p.c2 >= d.slider2_lower - FingerLinkage::kLimitSlack &&
           p.c2 <= d.slider2_upper + FingerLinkage::kLimitSlack &&
           std::abs(q1) <= std::numbers::pi && std::abs(q2) <= std::numbers::pi;
  }

  FingerLinkage linkage_;
  FingerReach reach_;
};

}  // namespace

FingerDimensions finger_sign_change() noexcept {
  constexpr double kDegree = 0.017453292519943295;
  return {.rail_origin = {-0.012, 0.008},
          .rail_angle = 37.0 * kDegree,
          .body_d = {0.0285, 0.0},
          .body_e = {0.077, -0.039},
          .rod1 = 0.023,
          .rod2 = 0.014,
          .slider1_upper = 0.046,
          .slider2_upper = 0.040,
          .l_x_lower = 0.0,
          .l_x_upper = 0.050,
          .q_B_lower = -75.0 * kDegree,
          .q_B_upper = 41.5 * kDegree};
}

FingerDimensions scaled(const FingerDimensions& dimensions, double size) noexcept {
  FingerDimensions d = dimensions;
  for (double* length :
       {&d.proximal_phalanx, &d.rail_origin.x, &d.rail_origin.y, &d.body_d.x, &d.body_d.y,
        &d.body_e.x, &d.body_e.y, &d.rod1, &d.rod2, &d.slider1_lower, &d.slider1_upper,
        &d.slider2_lower, &d.slider2_upper, &d.l_x_lower, &d.l_x_upper}) {
    *length *= size;
  }
  return d;
}

std::unique_ptr<Kinematics> make_finger_exoskeleton(const FingerDimensions& dimensions) {
  return std::make_unique<FingerExoskeleton>(dimensions);
}

}  // namespace haptic::core
