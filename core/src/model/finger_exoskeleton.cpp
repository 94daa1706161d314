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

/// Box and slider limits (the latter exclude rods on the far side of their joints), and angles that
/// are not a turn away from what the linkage assembles to.
bool acceptable(const FingerDimensions& d, double q1, double q2, const ClosedPose& p) noexcept {
  constexpr double kSlack = FingerLinkage::kLimitSlack;
  return p.l >= d.l_x_lower - kSlack && p.l <= d.l_x_upper + kSlack &&
         p.t >= d.q_B_lower - kSlack && p.t <= d.q_B_upper + kSlack &&
         p.c1 >= d.slider1_lower - kSlack && p.c1 <= d.slider1_upper + kSlack &&
         p.c2 >= d.slider2_lower - kSlack && p.c2 <= d.slider2_upper + kSlack &&
         std::abs(q1) <= std::numbers::pi && std::abs(q2) <= std::numbers::pi;
}

}  // namespace

struct FingerExoskeleton::Parts {
  explicit Parts(const FingerDimensions& d) : linkage(checked(d)), reach(linkage) {}
  FingerLinkage linkage;
  FingerReach reach;
};

FingerExoskeleton::FingerExoskeleton(const FingerDimensions& d)
    : Kinematics({{"l_x", Unit::kMetre, true, d.l_x_lower, d.l_x_upper},
                  {"q_B", Unit::kRadian, false, d.q_B_lower, d.q_B_upper}},
                 ConfigurationSpace(
                     {{"q_o1_mcp", Unit::kRadian, CoordinateKind::kLinear, d.proximal_phalanx},
                      {"q_o2_pip", Unit::kRadian, CoordinateKind::kLinear}})),
      parts_(std::make_unique<Parts>(d)),
      self_{this, 0} {
  mean_J_a_ = parts_->reach.mean_actuated_jacobian();
}

FingerExoskeleton::~FingerExoskeleton() = default;

MapStatus FingerExoskeleton::evaluate(const VecQ& q, VecX& x_probe, MatXQ& J) const noexcept {
  LinkagePose p;
  if (!parts_->linkage.pose(q[0], q[1], p)) return MapStatus::kCannotClose;
  x_probe.resize(2);
  x_probe << p.q1, p.q2;
  J.resize(2, 2);
  J << p.J(0, 0), p.J(0, 1), p.J(1, 0), p.J(1, 1);
  return MapStatus::kOk;
}

MapStatus FingerExoskeleton::position(const VecQ& q, VecX& x_probe) const noexcept {
  double q1 = 0.0, q2 = 0.0;
  if (!parts_->linkage.joints(q[0], q[1], q1, q2)) return MapStatus::kCannotClose;
  x_probe.resize(2);
  x_probe << q1, q2;
  return MapStatus::kOk;
}

InverseStatus FingerExoskeleton::inverse(const VecX& x, VecQ& q) const noexcept {
  const FingerLinkage& linkage = parts_->linkage;
  q.resize(2);
  ClosedPose closed;
  if (linkage.closed_inverse(x[0], x[1], closed) &&
      acceptable(linkage.dimensions(), x[0], x[1], closed)) {
    q[0] = closed.l;
    q[1] = closed.t;
    return InverseStatus::kExact;
  }
  const ReachPoint nearest = parts_->reach.nearest(x[0], x[1]);
  q[0] = nearest.l;
  q[1] = nearest.t;
  return InverseStatus::kUnreachable;
}

std::span<const Mechanism> FingerExoskeleton::mechanisms() const noexcept {
  return {&self_, 1};
}

MapStatus FingerExoskeleton::constraints(const VecQ& q, Constraints& out) const noexcept {
  return parts_->reach.constraints(q[0], q[1], out) ? MapStatus::kOk : MapStatus::kCannotClose;
}

Drawing FingerExoskeleton::drawing() const {
  return finger_drawing(parts_->linkage.dimensions());
}

InverseStatus FingerExoskeleton::follow(const Eigen::Vector2d& x, const Eigen::Vector2d& x_dot,
                                        Motion& out) const noexcept {
  ClosedPose closed;
  Motion motion;
  if (!parts_->linkage.closed_motion(x, x_dot, closed, motion) ||
      !acceptable(parts_->linkage.dimensions(), x[0], x[1], closed)) {
    return InverseStatus::kUnreachable;
  }
  motion.q << closed.l, closed.t;
  out = motion;
  return InverseStatus::kExact;
}

MapStatus FingerExoskeleton::velocity_product(const VecQ& q, const Eigen::Vector2d& q_dot,
                                              Eigen::Vector2d& out) const noexcept {
  const bool closes = parts_->linkage.velocity_product(q[0], q[1], q_dot[0], q_dot[1], out);
  return closes ? MapStatus::kOk : MapStatus::kCannotClose;
}

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

std::unique_ptr<FingerExoskeleton> make_finger_exoskeleton(const FingerDimensions& dimensions) {
  return std::make_unique<FingerExoskeleton>(dimensions);
}

}  // namespace haptic::core
