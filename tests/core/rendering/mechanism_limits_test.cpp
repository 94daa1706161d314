// core/METHOD.md#projection-algorithm and core/METHOD.md#worst-cases: limits of the mechanism
// beside the box of q*, by active set in the iteration.
#include "haptic/core/rendering/mechanism_limits.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <random>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/hand_exoskeleton.hpp"
#include "tests/core/model/nearest_pose.hpp"
#include "tests/core/model/sample_hands.hpp"
#include "tests/core/model/sample_maps.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/support/dense_oracle.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

using Limits = std::function<void(double, double, Constraints&)>;

/// A map's iteration under limits of its first two DoFs: these, or the map's own.
class Limited final : public samples::Wrapped {
 public:
  explicit Limited(std::unique_ptr<Kinematics> map, Limits limits = {})
      : Wrapped(*map), map_(std::move(map)), limits_(std::move(limits)) {}
  std::span<const Mechanism> mechanisms() const noexcept override { return {&self_, 1}; }
  MapStatus constraints(const VecQ& q, Constraints& out) const noexcept override {
    if (!limits_) return map_->constraints(q, out);
    limits_(q[0], q[1], out);
    return MapStatus::kOk;
  }

 private:
  const Mechanism self_{this, 0};
  std::unique_ptr<Kinematics> map_;
  Limits limits_;
};

/// x = q in a box of +-1 m, inside the disk of radius 0.5 and, where asked for, below a + b = 0.6.
Limited disk(bool with_line) {
  return Limited(samples::linear_map(Eigen::Matrix2d::Identity(), 1, 1.0),
                 [with_line](double a, double b, Constraints& limits) {
                   limits[1] = {0.25 - a * a - b * b, {-2.0 * a, -2.0 * b}};
                   if (with_line) limits[3] = {0.6 - a - b, {-1.0, -1.0}};
                 });
}

ProjectionModel model_of(const Kinematics& map, const TaskMetric& metric = {}) {
  ProjectionSettings settings;
  settings.metric = metric;
  settings.iteration.max_steps = 40;
  return {map, settings};
}

Projection solve_limited(const ProjectionModel& model, const VecX& x, const VecQ& seed) {
  ProxySolver solver(model);
  Projection out;
  solver.solve(x, seed, VecA::Constant(model.layout().n_a(), 1500.0), out);
  return out;
}

/// Least room of the constraints of a mechanism in a map at q; -infinity if it has no pose there.
double least_room(const Mechanism& mechanism, const VecQ& q) {
  Constraints constraints;
  double least = HUGE_VAL;
  if (mechanism.kinematics->constraints(q.segment(mechanism.first_q, 2), constraints) !=
      MapStatus::kOk) {
    return -HUGE_VAL;
  }
  for (const Constraint& constraint : constraints) least = std::min(least, constraint.room);
  return least;
}

void expect_inside(const Kinematics& map, const VecQ& q) {
  for (const Mechanism& each : map.mechanisms()) {
    EXPECT_GE(least_room(each, q), -1e-9) << "mechanism at " << each.first_q;
  }
}

bool allowed(const Kinematics& map, const VecQ& q) {
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    const DofSpec& dof = map.dofs()[static_cast<std::size_t>(k)];
    if (q[k] < dof.lower || q[k] > dof.upper) return false;
  }
  const auto mechanisms = map.mechanisms();
  return std::all_of(mechanisms.begin(), mechanisms.end(),
                     [&q](const Mechanism& each) { return least_room(each, q) >= 0.0; });
}

/// No random allowed pose near q*, in steps of `size` times the box, may be nearer to x. Says
/// how many there were.
int expect_none_nearer(const Kinematics& map, const VecX& x, const Projection& out, double size) {
  std::mt19937_64 random(9);
  std::normal_distribution<double> step(0.0, size);
  int judged = 0;
  VecX other;
  for (int n = 0; n < 3000; ++n) {
    VecQ near = out.q_star;
    for (Eigen::Index k = 0; k < near.size(); ++k) {
      const DofSpec& dof = map.dofs()[static_cast<std::size_t>(k)];
      near[k] += step(random) * (dof.upper - dof.lower);
    }
    if (!allowed(map, near) || map.position(near, other) != MapStatus::kOk) continue;
    ++judged;
    EXPECT_GT((x - other).norm(), out.residual - 1e-9) << near.transpose();
  }
  return judged;
}

/// (W + mu) q* = W x with the mu > 0 that brings q* onto the circle; radial without a metric.
TEST(MechanismLimits, MultiplierLocatesTheDisksPoint) {
  const Limited map = disk(false);
  for (const Eigen::Matrix2d& W :
       {Eigen::Matrix2d(Eigen::Matrix2d::Identity()), Eigen::Matrix2d{{3.0, 1.0}, {1.0, 1.0}}}) {
    const ProjectionModel model = model_of(map, TaskMetric::from_matrix(W));
    for (double angle = 0.0; angle < 6.0; angle += 0.4) {
      const VecX x = 0.8 * two(std::cos(angle), std::sin(angle));
      double low = 0.0, high = 100.0;
      Eigen::Vector2d want;
      for (int n = 0; n < 200; ++n) {
        const double mu = 0.5 * (low + high);
        want = oracle::inverse(W + mu * Eigen::Matrix2d::Identity()) * (W * x);
        (want.norm() > 0.5 ? low : high) = mu;
      }
      const Projection out = solve_limited(model, x, two(-0.1, 0.2));
      EXPECT_EQ(out.status, ProjectionStatus::kUnreachable);
      EXPECT_NEAR((out.q_star - want).norm(), 0.0, 1e-8) << angle;
    }
  }
  const Projection inside = solve_limited(model_of(map), two(0.3, -0.3), two(-0.1, 0.2));
  EXPECT_EQ(inside.status, ProjectionStatus::kConverged);
  EXPECT_NEAR((inside.q_star - two(0.3, -0.3)).norm(), 0.0, 1e-12);
}

TEST(MechanismLimits, TwoLimitsMakeACorner) {
  const Limited map = disk(true);
  // a + b = 0.6 on the circle: a = 0.3 +- sqrt(0.125 - 0.09). Beyond the corner along its cone.
  const double half = std::sqrt(0.125 - 0.09);
  const VecX corner = two(0.3 + half, 0.3 - half);
  for (const double share : {0.2, 0.5, 0.8}) {
    const VecX out_of_it =
        corner + 0.3 * (share * corner.normalized() + (1.0 - share) * two(1, 1).normalized());
    const Projection out = solve_limited(model_of(map), out_of_it, two(0.1, 0.0));
    EXPECT_NEAR((out.q_star - corner).norm(), 0.0, 1e-9) << share;
  }
  // On the line between the corners.
  const Projection line = solve_limited(model_of(map), two(0.5, 0.4), two(0.0, -0.1));
  EXPECT_NEAR((line.q_star - two(0.35, 0.25)).norm(), 0.0, 1e-9);
  // From a seed outside of all it ends inside.
  const Projection out = solve_limited(model_of(disk(false)), two(0.2, 0.9), two(0.9, 0.9));
  EXPECT_NEAR((out.q_star - 0.5 * two(0.2, 0.9).normalized()).norm(), 0.0, 1e-9);
}

/// tests/report/STUDY.md#unreachable-proxies and others: the iteration, from beside it, ends where
/// the traced edge of the closed form does.
TEST(MechanismLimits, IterationEndsAtTheFingersOptimum) {
  const Limited map(make_finger_exoskeleton(finger_sign_change()));
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> mcp(-1.0, 2.3), pip(-0.6, 2.9), l(-0.002, 0.002),
      t(-0.05, 0.05);
  int judged = 0, elsewhere = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const VecX x = two(mcp(random), pip(random));
    VecQ best;
    if (map.map().inverse(x, best) != InverseStatus::kUnreachable) continue;
    const double least = Instant(map, best, x).dx.norm();
    if (least > 0.7) continue;  // far off the surface other minima are as near
    const VecQ seed = best + two(l(random), t(random));
    Constraints limits;
    if (map.constraints(seed, limits) != MapStatus::kOk) continue;
    if (limits[0].room < 0.0 || limits[2].room < 0.0 || limits[4].room < 0.0) continue;
    ++judged;
    const Projection out = solve_limited(model_of(map), x, seed);
    expect_inside(map, out.q_star);
    EXPECT_GT(out.residual, least - 1e-6) << "the closed form's is the global one";
    if (out.residual < least + 1e-6) continue;
    ++elsewhere;
    EXPECT_GT(expect_none_nearer(map, x, out, 1e-4), 100) << "then it is a minimum of its own";
  }
  EXPECT_LT(elsewhere, judged / 50);
  EXPECT_GT(judged, 100);
}

/// If W is no multiple of the identity, the closed form's nearest pose is not the nearest: by
/// exhaustion no pose is nearer than the answer.
TEST(MechanismLimits, UnreachablePoseIsNearestInMetric) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  const Eigen::Matrix2d W = (Eigen::Matrix2d() << 4.0, 1.5, 1.5, 1.0).finished();
  const ProjectionModel model = model_of(*finger, TaskMetric::from_matrix(W));
  for (const VecX& x :
       {two(-0.5, 0.3), two(-0.7, 0.35), two(-0.5, -0.5), two(1.6, 1.0), two(0.3, 2.3)}) {
    SubspaceExact exact(model);
    const Projection out = projected(exact, Instant(*finger, two(0.015, -0.2), x), one(1500.0));
    EXPECT_EQ(out.status, ProjectionStatus::kUnreachable);
    EXPECT_LE(out.residual, nearest_pose(finger_sign_change(), x, W).distance + 1e-9)
        << x.transpose();
    expect_inside(*finger, out.q_star);
  }
}

/// A hand whose iteration has no closed form: a proxy that asks for a finger beyond its sliders is
/// not followed there, and near the answer nothing allowed is nearer.
TEST(MechanismLimits, HoldEverySliderOfAHand) {
  const auto hand = make_tracked_hand(five_fingers_on_a_palm());
  ASSERT_EQ(hand->mechanisms().size(), 5u);
  VecQ q = VecQ::Zero(hand->layout().n_q()), beyond;
  for (int f = 0; f < 5; ++f) q.segment<2>(6 + 2 * f) = two(0.0118, -0.15);
  beyond = q;
  // The index's slider 2 ends here: c2 is near its upper limit at small flexion.
  const Mechanism& index = hand->mechanisms()[1];
  for (int step = 0; step < 200 && least_room(index, beyond) > -0.002; ++step) {
    beyond[index.first_q + 1] += 0.005;
  }
  ASSERT_LT(least_room(index, beyond), -0.001) << "the proxy is beyond a slider's end";
  VecX x;
  ASSERT_EQ(hand->position(beyond, x), MapStatus::kOk);
  const Projection out = solve_limited(model_of(*hand), x, q);
  expect_inside(*hand, out.q_star);
  EXPECT_EQ(out.status, ProjectionStatus::kUnreachable);
  EXPECT_GT(out.residual, 1e-4);
  EXPECT_GT(expect_none_nearer(*hand, x, out, 1e-4), 300);
}

}  // namespace
}  // namespace haptic::core
