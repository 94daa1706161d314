#include "haptic/core/rendering/per_contact.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <random>

#include "haptic/core/model/serial_chain.hpp"
#include "haptic/core/passivity/force_fade.hpp"
#include "tests/core/linear/random_matrix.hpp"
#include "tests/core/model/sample_maps.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/dense_oracle.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

using samples::gaussian;

struct Sizes {
  int n_x, n_q, n_a;
};
constexpr Sizes kSizes[] = {{2, 2, 1}, {6, 2, 1}, {6, 6, 3}, {7, 3, 2}, {27, 10, 4}, {3, 3, 3}};

std::unique_ptr<Kinematics> of_angles(const Eigen::MatrixXd& A, int n_a) {
  return samples::linear_map(A, n_a, 1e6, Unit::kRadian);
}

/// W = (S J^+)^T.
Eigen::MatrixXd levers(const Eigen::MatrixXd& J, int n_a) {
  return J.completeOrthogonalDecomposition().pseudoInverse().topRows(n_a).transpose();
}

/// A random case: a map, a displacement, contacts.
struct ContactCase {
  Sizes sizes{};
  Eigen::MatrixXd A{}, W{};
  VecX dx{};
  VecA Z_q{}, limit{}, tau_8{};
  Contacts contacts{};

  ContactCase(std::mt19937_64& random, const Sizes& of, int count, double depth) : sizes(of) {
    std::uniform_real_distribution<double> stiffness(10.0, 5000.0);
    do {
      A = gaussian(random, sizes.n_x, sizes.n_q);
    } while (oracle::condition(A) > 30.0);
    W = levers(A, sizes.n_a);
    dx = 0.01 * gaussian(random, sizes.n_x, 1);
    Z_q.resize(sizes.n_a);
    for (int i = 0; i < sizes.n_a; ++i) Z_q[i] = stiffness(random);
    limit = VecA::Constant(sizes.n_a, 1e6);
    tau_8 = Z_q.cwiseProduct(VecA(W.transpose() * dx));
    contacts.into.resize(sizes.n_x, count);
    contacts.depth = PlaneSet::Offsets::Constant(count, depth);
    for (int i = 0; i < count; ++i) {
      contacts.into.col(i) = VecX(gaussian(random, sizes.n_x, 1)).normalized();
    }
  }
  [[nodiscard]] VecA force(Projection* answer = nullptr) const {
    const auto map = of_angles(A, sizes.n_a);
    PerContact rule{ProjectionModel(*map)};
    const Instant at(*map, VecQ::Zero(sizes.n_q), dx);
    const Projection out = projected(rule, at, Z_q, true, {&contacts, &limit});
    if (answer != nullptr) *answer = out;
    return spring_force(map->layout(), out, at.q, Z_q);
  }
  /// Work of tau_a along the way out of contact i.
  [[nodiscard]] double out_of(int i, const VecA& tau_a) const {
    return -contacts.into.col(i).dot(VecX(W * tau_a));
  }
  /// The most that deep contact i may be pushed in: Eq. (32).
  [[nodiscard]] double slack(int i) const {
    const Eigen::VectorXd out = contacts.into.col(i);
    const double cosine = (W * W.colPivHouseholderQr().solve(out)).norm();
    return std::max(0.0, 1.0 - 20.0 * cosine) * cosine * (W * tau_8).norm();
  }
};

TEST(PerContact, IsEquation8WithoutContradiction) {
  std::mt19937_64 random(5);
  for (const Sizes& sizes : kSizes) {
    for (int trial = 0; trial < 100; ++trial) {
      ContactCase c(random, sizes, 2, 0.1);
      // Contacts that Eq. (8) pushes out of.
      for (int i = 0; i < 2; ++i) {
        if (c.out_of(i, c.tau_8) < 0.0) c.contacts.into.col(i) *= -1.0;
      }
      Projection answer;
      EXPECT_LT((c.force(&answer) - c.tau_8).norm(), 1e-12 * c.tau_8.norm());
      EXPECT_FALSE(answer.contradicted);
      EXPECT_EQ(answer.damping, 0.0);
    }
  }
}

TEST(PerContact, PushesIntoNoDeepContact) {
  std::mt19937_64 random(7);
  int held = 0;
  for (const Sizes& sizes : kSizes) {
    for (int trial = 0; trial < 200; ++trial) {
      ContactCase c(random, sizes, 1 + trial % 4, 0.1);
      // An actuator without a spring gives nothing, and the others push in no deeper for it.
      if (sizes.n_a > 1 && trial % 3 == 0) c.Z_q[trial % sizes.n_a] = 0.0;
      c.tau_8 = c.Z_q.cwiseProduct(VecA(c.W.transpose() * c.dx));
      c.limit.setConstant(0.5 * c.tau_8.cwiseAbs().maxCoeff());
      Projection answer;
      const VecA tau = c.force(&answer);
      held += answer.contradicted ? 1 : 0;
      ASSERT_TRUE(tau.allFinite());
      // One actuator: the limit is the caller's, along a potential.
      const double over = sizes.n_a > 1 ? (tau.cwiseAbs() - c.limit).maxCoeff() : 0.0;
      EXPECT_LE(over, 1e-9 * c.limit[0]);
      for (int i = 0; i < c.contacts.size(); ++i) {
        EXPECT_GE(c.out_of(i, tau), -c.slack(i) - 1e-9 * c.tau_8.norm())
            << sizes.n_a << " " << trial;
      }
    }
  }
  EXPECT_GT(held, 300);
}

TEST(PerContact, NearestToEquation8AsFelt) {
  std::mt19937_64 random(11);
  for (const Sizes& sizes : kSizes) {
    for (int trial = 0; trial < 50; ++trial) {
      ContactCase c(random, sizes, 3, 0.1);
      if (sizes.n_a > 1) c.limit.setConstant(0.7 * c.tau_8.cwiseAbs().maxCoeff());
      const VecA tau = c.force();
      const double felt = (c.W * (tau - c.tau_8)).norm();
      for (int other = 0; other < 200; ++other) {
        VecA rival = tau + VecA(gaussian(random, sizes.n_a, 1)) * 0.3 * c.tau_8.norm();
        bool allowed = (rival.array().abs() <= c.limit.array()).all();
        for (int i = 0; i < 3; ++i) allowed = allowed && c.out_of(i, rival) >= 0.0;
        if (!allowed) continue;
        EXPECT_GE((c.W * (rival - c.tau_8)).norm(), felt * (1.0 - 1e-9));
      }
    }
  }
}

TEST(PerContact, IsContinuousInEveryDepth) {
  std::mt19937_64 random(13);
  for (const Sizes& sizes : kSizes) {
    for (int trial = 0; trial < 20; ++trial) {
      ContactCase c(random, sizes, 3, 0.1);
      const double band = 0.25 * kDegree;
      VecA last;
      constexpr int kSteps = 400;
      for (int k = -20; k <= kSteps; ++k) {
        c.contacts.depth[0] = 1.5 * band * k / kSteps;
        const VecA tau = c.force();
        if (k > -20) {
          // A slope of the whole force over the band, times what the geometry amplifies.
          EXPECT_LT((c.W * (tau - last)).norm(), 40.0 / kSteps * (c.W * c.tau_8).norm());
        }
        last = tau;
      }
    }
  }
}

TEST(PerContact, ContradictingContactsGiveNothing) {
  Contacts contacts;
  contacts.into = Eigen::Matrix2d::Identity();
  contacts.depth = PlaneSet::Offsets::Constant(2, 0.1);
  // Levers of opposite sign: 1 N flexes one joint, extends the other.
  const auto map = of_angles((Eigen::Matrix2d() << 40.0, 1.0, -60.0, 1.0).finished(), 1);
  const Instant at(*map, two(0.0, 0.0), two(-0.12, -0.1));
  PerContact rule{ProjectionModel(*map)};
  // A held proxy's joint angles that are displaced the same way are the same two contacts.
  for (const ContactView& view : {ContactView{&contacts}, ContactView{}}) {
    const Projection out = projected(rule, at, one(1500.0), true, view);
    EXPECT_EQ(out.q_star[0], 0.0);
    EXPECT_TRUE(out.contradicted);
  }
}

TEST(PerContact, JointsDisplacedOppositelyAreOneWall) {
  Eigen::Matrix2d inverse;
  inverse << 40.0, 60.0, 1.0, -1.0;  // levers of the same sign
  const auto map = of_angles(inverse.inverse(), 1);
  const Instant at(*map, two(0.0, 0.0), two(0.1, -0.05));
  SubspaceLinear linear{ProjectionModel(*map)};
  PerContact rule{ProjectionModel(*map)};
  const Projection out = projected(rule, at, one(1500.0));
  EXPECT_FALSE(out.contradicted);
  EXPECT_EQ(out.q_star[0], projected(linear, at, one(1500.0)).q_star[0]);
}

/// The force is continuous while joints begin to be displaced, in either sense.
TEST(PerContact, HeldProxyMovesWithoutStep) {
  std::mt19937_64 random(31);
  constexpr int kSteps = 20000;
  int held = 0;
  for (int line = 0; line < 60; ++line) {
    const int n = 2 + line % 3;
    const Eigen::MatrixXd A = gaussian(random, n, n);
    if (oracle::condition(A) > 20.0) continue;
    const auto map = of_angles(A, 1);
    PerContact rule{ProjectionModel(*map)};
    const VecX from = 0.02 * gaussian(random, n, 1), to = 0.02 * gaussian(random, n, 1);
    const double band = contact_band(ProjectionModel(*map));
    // Per step: tau_8's own change, and a share's over the band of depth and over that of leverage,
    // which a displacement of one band may turn.
    const double lever = levers(A, 1).norm(), step = (to - from).norm() / kSteps;
    const double largest = lever * step * (2.0 + 21.0 * std::max(from.norm(), to.norm()) / band);
    double before = 0.0;
    for (int k = 0; k <= kSteps; ++k) {
      const VecX dx = from + (to - from) * k / kSteps;
      const Projection out = projected(rule, Instant(*map, VecQ::Zero(n), dx), one(1500.0));
      held += out.contradicted ? 1 : 0;
      if (k > 0) {
        ASSERT_LE(std::abs(out.q_star[0] - before), largest) << line << " " << k;
      }
      before = out.q_star[0];
    }
  }
  EXPECT_GT(held, 1000);
}

/// core/METHOD.md#damping-near-singular-poses: a 2R arm, its shoulder driven, is moved through its
/// stretched elbow with the proxy 2 mm outward.
class StretchedElbow : public ::testing::Test {
 protected:
  static std::unique_ptr<Kinematics> arm() {
    SerialChainParameters p;
    for (int i = 0; i < 2; ++i) {
      ChainJoint joint;
      joint.name = "j" + std::to_string(i);
      joint.actuated = i == 0;
      if (i == 1) joint.origin.position = {0.3, 0.0, 0.0};
      p.joints.push_back(joint);
    }
    ChainOutput tip;
    tip.name = "tip";
    tip.offset.position = {0.25, 0.0, 0.0};
    p.outputs.push_back(tip);
    return make_serial_chain(p);
  }
  /// The shoulder's torque at elbow `bend`, N m.
  static double torque(RendererKind kind, double bend, Projection& out) {
    static const auto map = arm();
    Renderer renderer(kind, *map);
    const Instant at(*map, two(0.4, bend), outward(*map, two(0.4, bend), 0.002));
    out = projected(renderer, at, one(50.0));
    return spring_force(map->layout(), out, at.q, one(50.0))[0];
  }
  /// A proxy that far beyond the tip, m.
  static VecX outward(const Kinematics& map, const VecQ& q, double far) {
    VecX tip;
    EXPECT_EQ(map.position(q, tip), MapStatus::kOk);
    return tip + far * tip.normalized();
  }
};

TEST_F(StretchedElbow, TorquePassesThroughZero) {
  Projection out;
  constexpr double kStep = 1e-5;  // rad: 1 rad/s at 100 kHz
  double last = torque(RendererKind::kPerContact, -0.2, out), jump = 0.0, most = 0.0;
  double last_8 = torque(RendererKind::kSubspaceLinear, -0.2, out), jump_8 = 0.0;
  for (int k = 1; k <= 40000; ++k) {
    const double bend = -0.2 + k * kStep;
    const double tau = torque(RendererKind::kPerContact, bend, out);
    ASSERT_TRUE(std::isfinite(tau));
    jump = std::max(jump, std::abs(tau - last));
    most = std::max(most, std::abs(tau));
    last = tau;
    const double tau_8 = torque(RendererKind::kSubspaceLinear, bend, out);
    jump_8 = std::max(jump_8, std::abs(tau_8 - last_8));
    last_8 = tau_8;
  }
  EXPECT_LT(jump, 0.005 * most);
  EXPECT_GT(jump_8, most) << "Eq. (8) jumps by more than the damped rule ever gives";
  EXPECT_NEAR(torque(RendererKind::kPerContact, 0.0, out), 0.0, 1e-6 * most);
  EXPECT_NEAR(out.damping, 1.0, 1e-9);
}

TEST_F(StretchedElbow, DampsNothingBelowCondition100) {
  Projection out, linear;
  for (double bend = -1.5; bend <= 1.5; bend += 0.001) {
    const double tau = torque(RendererKind::kPerContact, bend, out);
    const double tau_8 = torque(RendererKind::kSubspaceLinear, bend, linear);
    if (linear.condition < 100.0) {
      EXPECT_EQ(tau, tau_8);
      EXPECT_EQ(out.damping, 0.0);
    }
  }
}

/// 1000 crossings by 0.1 deg of the elbow, with proxies up to 4 mm away in any direction that stay
/// or go with the tip, and behind two contacts that are deeper than the band. Neither such a step
/// nor 0.1 mm of the proxy changes the force by more than 5 % of its limit. What contacts allow
/// changes with their leverage, too: at 100 deg/s that adds what a force may fade by in a tick.
TEST_F(StretchedElbow, CrossingsAreGentle) {
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  const auto map = arm();
  for (int crossing = 0; crossing < 1000; ++crossing) {
    const VecA limit = VecA::Constant(1, 1.5 + 20.0 * any(random));
    const double away = 0.001 + 0.003 * any(random), turned = 2.0 * kPi * any(random);
    Contacts contacts;
    contacts.into.setZero(3, 2);
    contacts.depth.setConstant(2, 0.1);
    for (int i = 0; i < 2; ++i) {
      contacts.into.col(i).head<2>() = VecX(gaussian(random, 2, 1)).normalized();
    }
    const bool held = crossing % 2 == 0, touched = crossing % 4 >= 2;
    const double most = (touched ? 0.055 : 0.05) * limit[0];
    PerContact rule{ProjectionModel(*map)};
    EasedForce eased(1);
    double last = 0.0;
    for (double bend = -0.15; bend <= 0.15; bend += 0.1 * kDegree) {
      const VecX x = outward(*map, two(turned, held ? 0.0 : bend), away);
      const auto torque = [&](const VecX& to, bool tick) {
        const Instant at(*map, two(turned, bend), to);
        const Projection out =
            projected(rule, at, one(30.0), true, {touched ? &contacts : nullptr, &limit});
        const auto spring = [&](const VecQ& q) {
          return VecA::Constant(1, std::clamp(30.0 * (q[0] - at.q[0]), -limit[0], limit[0]));
        };
        const VecA allowed = spring(out.q_star);
        if (!tick) return allowed[0];
        return eased.step(out.contradicted ? spring(out.q_wish) : allowed, allowed, limit, 1e-3)[0];
      };
      const double tau = torque(x, true);
      if (bend > -0.15) {
        ASSERT_LE(std::abs(tau - last), most) << crossing << " " << bend;
      }
      last = tau;
      const VecX shift = 1e-4 * VecX(gaussian(random, 3, 1)).normalized();
      if (touched) continue;  // the shares of two slanted contacts change with their depths
      ASSERT_LE(std::abs(torque(x + shift, false) - tau), 0.05 * limit[0])
          << crossing << " " << bend;
    }
  }
}

/// Damping begins nowhere far from the singular pose
/// and below the limits, to the bit.
TEST_F(StretchedElbow, DampsNothingFarOrBelowLimits) {
  const auto map = arm();
  const VecA limit = VecA::Constant(1, 3.0);
  SubspaceLinear linear{ProjectionModel(*map)};
  PerContact rule{ProjectionModel(*map)};
  int damped = 0, below = 0;
  for (const double away : {0.0005, 0.004, 0.05}) {
    for (double bend = -1.5; bend <= 1.5; bend += 0.001) {
      const Instant at(*map, two(0.4, bend), outward(*map, two(0.4, bend), away));
      const Projection out = projected(rule, at, one(30.0), true, {nullptr, &limit});
      const Projection plain = projected(linear, at, one(30.0));
      const double tau = 30.0 * std::abs(plain.q_star[0] - at.q[0]);
      damped += out.damping > 0.0 ? 1 : 0;
      if (plain.condition < 10.0 || (plain.condition < 25.0 && tau < limit[0])) {
        ++below;
        ASSERT_EQ(out.damping, 0.0) << bend;
        ASSERT_EQ(out.q_star[0], plain.q_star[0]) << bend;
      }
    }
  }
  EXPECT_GT(damped, 100);
  EXPECT_GT(below, 5000);
}

}  // namespace
}  // namespace haptic::core
