/// The mechanics of a worn finger, checked by energy and by statics from independent algebra. The
/// end states of tests/report/STUDY.md#chosen-presses-finger_sign_change are held by report.values.
#include "hw/simulated/finger_physics.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cmath>
#include <numbers>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/stylus.hpp"
#include "hw/motion/minimum_jerk.hpp"
#include "tests/hw/simulated/one_finger.hpp"

namespace haptic::hw {
namespace {

constexpr double kDeg = std::numbers::pi / 180.0;
constexpr double kDt = 1e-4;

/// Lets the user rise from (0, 0) to x_des in 0.8 s under a constant force; 2 s in all.
FingerPhysics pressed(const FingerParameters& p, const Eigen::Vector2d& x_des, double tau_a,
                      const std::shared_ptr<const core::Kinematics>& finger = test::one_finger()) {
  FingerPhysics physics(p, finger, Eigen::Vector2d::Zero());
  for (int i = 0; i < 20000; ++i) physics.step(kDt, minimum_jerk(i * kDt / 0.8) * x_des, tau_a);
  return physics;
}

/// w = dl_x/dx by central differences of the inverse map alone.
Eigen::Vector2d lever_arms(const Eigen::Vector2d& x) {
  constexpr double h = 1e-6;
  Eigen::Vector2d w;
  for (int i = 0; i < 2; ++i) {
    core::VecX ahead(2), behind(2);
    ahead << x[0], x[1];
    behind = ahead;
    ahead[i] += h;
    behind[i] -= h;
    core::VecQ q_ahead = core::VecQ::Zero(2), q_behind = core::VecQ::Zero(2);
    EXPECT_EQ(test::one_finger()->inverse(ahead, q_ahead), core::InverseStatus::kExact);
    EXPECT_EQ(test::one_finger()->inverse(behind, q_behind), core::InverseStatus::kExact);
    w[i] = (q_ahead[0] - q_behind[0]) / (2 * h);
  }
  return w;
}

TEST(FingerPhysics, IsOfAFingerOnly) {
  const std::shared_ptr<const core::Kinematics> stylus = core::make_stylus({});
  EXPECT_THROW(FingerPhysics({}, stylus, Eigen::Vector2d::Zero()), core::DeviceError);
}

TEST(FingerPhysics, ForceBalancesTheHandAtRest) {
  // w tau_a = K_h (x - x_des), both joints.
  const FingerParameters p;
  for (const double tau_a : {-14.0, -6.0, -1.0, 0.0, 0.5, 4.0}) {
    for (const Eigen::Vector2d& aim :
         {Eigen::Vector2d(50 * kDeg, 50 * kDeg), Eigen::Vector2d(30 * kDeg, 40 * kDeg)}) {
      const FingerPhysics physics = pressed(p, aim, tau_a);
      ASSERT_TRUE(physics.in_reach());
      EXPECT_LT(physics.x_dot().norm(), 1e-6);
      const Eigen::Vector2d user = p.hand_stiffness * (physics.x() - aim);
      const Eigen::Vector2d device = lever_arms(physics.x()) * tau_a;
      EXPECT_LT((user - device).norm(), 1e-6 * (1.0 + user.norm())) << tau_a;
    }
  }
}

TEST(FingerPhysics, TheFirstStepFollowsNewton) {
  // From rest, no damping: x_ddot = (I + m w w^T)^-1 (K_h (x_des - x) + w tau_a).
  FingerParameters p{.hand_damping = 0.0, .actuator_damping = 0.0};
  const Eigen::Vector2d x(30 * kDeg, 30 * kDeg), aim(40 * kDeg, 20 * kDeg);
  FingerPhysics physics(p, test::one_finger(), x);
  physics.step(1e-6, aim, 7.0);
  // tests/report/STUDY.md#poses-of-finger_sign_change prints J at (30, 30) deg; w is the first row
  // of its inverse.
  Eigen::Matrix2d J;
  J << -47.670, -1.424, 78.460, 0.484;
  const Eigen::Vector2d w = J.inverse().row(0).transpose();
  Eigen::Matrix2d M = 0.05 * w * w.transpose();
  M(0, 0) += 1.2e-4;
  M(1, 1) += 4e-5;
  const Eigen::Vector2d expected = M.inverse() * (0.6 * (aim - x) + w * 7.0);
  EXPECT_LT((physics.x_dot() / 1e-6 - expected).norm(), 1e-3 * expected.norm());
}

TEST(FingerPhysics, TheActuatorMassMovesAlong) {
  // A free finger in flight, no user, no losses: kinetic energy stays while M(x) changes, and only
  // because of the velocity-product term (without it a quarter of it is gone).
  const auto drift = [](double dt) {
    FingerParameters p{.hand_stiffness = 1e-12, .hand_damping = 0.0, .actuator_damping = 0.0};
    FingerPhysics physics(p, test::one_finger(), {10 * kDeg, 20 * kDeg});
    const Eigen::Vector2d kick =
        Eigen::Vector2d(2.5e8, 3e8) / dt;  // one impulse, whatever the step
    for (int i = 0; i < 10; ++i) physics.step(dt, kick, 0.0);
    const double start = physics.kinetic();
    for (double t = 0.0; t < 0.02; t += dt) physics.step(dt, physics.x(), 0.0);
    EXPECT_TRUE(physics.in_reach());
    EXPECT_GT((physics.x() - Eigen::Vector2d(10 * kDeg, 20 * kDeg)).norm(), 5 * kDeg);
    return std::abs(physics.kinetic() / start - 1.0);
  };
  const double coarse = drift(1e-5);
  EXPECT_LT(coarse, 1e-3);
  EXPECT_LT(drift(1e-6), 0.3 * coarse);
}

TEST(FingerPhysics, AccountsForAllEnergyUnderForce) {
  FingerParameters p{.actuator_friction = 1.0};
  FingerPhysics physics(p, test::one_finger(), Eigen::Vector2d::Zero());
  const FingerEnergy& e = physics.energy();
  for (int i = 0; i < 30000; ++i) {
    const double t = i * kDt;
    const FingerEnergy last = e;
    physics.step(kDt, {0.8 + 0.2 * std::sin(4.0 * t), 0.8}, 6.0 * std::sin(7.0 * t));
    ASSERT_GE(e.friction, last.friction) << "friction and damping only take";
    ASSERT_GE(e.damping, last.damping);
    ASSERT_LE(physics.kinetic(), e.by_user + e.by_actuator + 1e-6) << "t = " << t;
  }
  const double put_in = e.by_user + e.by_actuator;
  const double taken = physics.kinetic() + e.damping + e.friction + e.stop;
  EXPECT_GT(e.damping + e.friction, 0.01);
  EXPECT_NEAR(put_in, taken, 0.03 * (e.damping + e.friction));
  EXPECT_LE(taken, put_in + 1e-6);
}

TEST(FingerPhysics, FrictionSticksWithoutCreeping) {
  // A force below F_c does not move the slider at all; one above it does.
  FingerParameters p{.actuator_friction = 5.0};
  const Eigen::Vector2d x(30 * kDeg, 30 * kDeg);
  FingerPhysics stuck(p, test::one_finger(), x);
  FingerPhysics loose = stuck;
  const double start = stuck.q()[0];
  for (int i = 0; i < 10000; ++i) {
    stuck.step(kDt, x, 4.9);
    loose.step(kDt, x, 6.0);
  }
  EXPECT_NEAR(stuck.q()[0], start, 1e-9);
  EXPECT_GT(loose.q()[0] - start, 1e-4);
}

TEST(FingerPhysics, StopsHoldTheFinger) {
  // tests/report/STUDY.md#unreachable-proxies: aims far outside. The finger rests at the edge, at
  // most K_h / (K_stop + K_h) of the way from the nearest pose towards its aim.
  for (const Eigen::Vector2d& aim :
       {Eigen::Vector2d(-0.5, 0.3), Eigen::Vector2d(-0.7, 0.35), Eigen::Vector2d(-1.0, 0.3),
        Eigen::Vector2d(-0.5, -0.5), Eigen::Vector2d(2.2, 1.0), Eigen::Vector2d(0.3, 2.9)}) {
    const FingerPhysics physics = pressed({}, aim, 0.0);
    EXPECT_LT(physics.x_dot().norm(), 1e-6);
    EXPECT_FALSE(physics.in_reach());
    core::VecX x(2), edge(2);
    x << physics.x()[0], physics.x()[1];
    core::VecQ q = core::VecQ::Zero(2);
    core::MatXQ J = core::MatXQ::Zero(2, 2);
    ASSERT_EQ(test::one_finger()->inverse(x, q), core::InverseStatus::kUnreachable);
    ASSERT_EQ(test::one_finger()->evaluate(q, edge, J), core::MapStatus::kOk);
    const double beyond = (x - edge).norm();
    EXPECT_LT(beyond, 0.025 * (aim - Eigen::Vector2d(edge[0], edge[1])).norm() + 1e-4);
    for (int i = 0; i < 2; ++i) {
      const core::DofSpec& dof = test::one_finger()->dofs()[static_cast<std::size_t>(i)];
      EXPECT_GE(physics.q()[i], dof.lower);
      EXPECT_LE(physics.q()[i], dof.upper);
    }
  }
}

/// Visits the end of a press on every side, in and out of reach, with and without force.
template <typename Visit>
void over_the_aims(const std::shared_ptr<const core::Kinematics>& finger, Visit visit) {
  for (const double mcp : {-0.8, 0.4, 2.0}) {
    for (const double pip : {-0.8, 0.8, 2.8}) {
      for (const double tau_a : {-40.0, 0.0, 10.0, 40.0}) {
        SCOPED_TRACE(testing::Message() << mcp << ", " << pip << ", " << tau_a);
        visit(pressed({}, {mcp, pip}, tau_a, finger));
      }
    }
  }
}

TEST(FingerPhysics, TheStopGivesNoEnergy) {
  // At the end all is at rest, and the finger never holds more than user and actuator gave.
  over_the_aims(test::one_finger(), [](const FingerPhysics& physics) {
    const FingerEnergy& e = physics.energy();
    EXPECT_GT(e.stop, -1e-6);
    EXPECT_LE(physics.kinetic(), e.by_user + e.by_actuator);
    EXPECT_LT(physics.x_dot().norm(), 1e-3);
  });
}

TEST(FingerPhysics, AToggleLeavesItFinite) {
  // The reach of finger_same_sign ends at toggle positions where the MCP is overstretched. Energy
  // is not conserved there.
  over_the_aims(core::make_finger_exoskeleton({}), [](const FingerPhysics& physics) {
    EXPECT_TRUE(physics.x().allFinite());
    EXPECT_LE(physics.x_dot().norm(), 100.0 + 1e-9);
  });
}

}  // namespace
}  // namespace haptic::hw
