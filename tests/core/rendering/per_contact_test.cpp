#include "haptic/core/rendering/per_contact.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <numbers>
#include <random>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/linear.hpp"
#include "haptic/core/model/serial_chain.hpp"
#include "haptic/core/rendering/renderer.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::core {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

struct Sizes {
  int n_x, n_q, n_a;
};
constexpr Sizes kSizes[] = {{2, 2, 1}, {6, 2, 1}, {6, 6, 3}, {7, 3, 2}, {27, 10, 4}, {3, 3, 3}};

Eigen::MatrixXd normal_matrix(std::mt19937_64& random, int rows, int columns) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd A(rows, columns);
  for (int i = 0; i < A.size(); ++i) A.data()[i] = normal(random);
  return A;
}

std::unique_ptr<Kinematics> map_of(const Eigen::MatrixXd& A, int n_a, Unit unit) {
  LinearMap map;
  for (int i = 0; i < A.cols(); ++i) {
    map.dofs.push_back({"q" + std::to_string(i), Unit::kMetre, i < n_a, -1e6, 1e6});
  }
  for (int i = 0; i < A.rows(); ++i) {
    map.coordinates.push_back({"x" + std::to_string(i), unit, CoordinateKind::kLinear});
  }
  map.A = A;
  return make_linear(map);
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
      A = normal_matrix(random, sizes.n_x, sizes.n_q);
    } while (oracle::condition(A) > 30.0);
    W = levers(A, sizes.n_a);
    dx = 0.01 * normal_matrix(random, sizes.n_x, 1);
    Z_q.resize(sizes.n_a);
    for (int i = 0; i < sizes.n_a; ++i) Z_q[i] = stiffness(random);
    limit = VecA::Constant(sizes.n_a, 1e6);
    tau_8 = Z_q.cwiseProduct(VecA(W.transpose() * dx));
    contacts.into.resize(sizes.n_x, count);
    contacts.depth = PlaneSet::Offsets::Constant(count, depth);
    for (int i = 0; i < count; ++i) {
      contacts.into.col(i) = VecX(normal_matrix(random, sizes.n_x, 1)).normalized();
    }
  }
  [[nodiscard]] VecA force(Projection* answer = nullptr) const {
    const auto map = map_of(A, sizes.n_a, Unit::kRadian);
    const VecQ q = VecQ::Zero(sizes.n_q);
    const VecX x_probe = VecX::Zero(sizes.n_x);
    const MatXQ J = A;
    PerContact rule{ProjectionModel(*map)};
    Projection out;
    rule.project(Probe{q, x_probe, J, {&contacts, &limit}}, dx, dx, Z_q, true, out);
    if (answer != nullptr) *answer = out;
    return Z_q.cwiseProduct(map->layout().select(out.q_star));
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

/// core/METHOD.md#the-best-a-device-can-do: both subspace and null-space method are best, of
/// different wishes.
TEST(BestForce, EqualsThePapersForItsWish) {
  std::mt19937_64 random(3);
  for (const Sizes& sizes : kSizes) {
    for (int trial = 0; trial < 100; ++trial) {
      const ContactCase c(random, sizes, 0, 0.0);
      const auto best = [&](const Eigen::VectorXd& wish) {
        return Eigen::VectorXd(c.W.colPivHouseholderQr().solve(wish));
      };
      const double scale = c.tau_8.norm();
      const Eigen::VectorXd by_eq_8 = best(c.W * c.Z_q.asDiagonal() * c.W.transpose() * c.dx);
      EXPECT_LT((by_eq_8 - c.tau_8).norm(), 1e-10 * scale);

      LeastSquares solver(sizes.n_x, map_of(c.A, sizes.n_a, Unit::kMetre)->layout());
      solver.solve(c.A, c.dx, c.Z_q);
      const Eigen::VectorXd null_space = solver.null_space_force();
      EXPECT_LT((best(c.dx) - null_space).norm(), 1e-10 * null_space.norm());
    }
  }
}

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
  for (const Sizes& sizes : kSizes) {
    for (int trial = 0; trial < 200; ++trial) {
      ContactCase c(random, sizes, 1 + trial % 4, 0.1);
      c.limit.setConstant(0.5 * c.tau_8.cwiseAbs().maxCoeff());
      const VecA tau = c.force();
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
}

TEST(PerContact, ActuatorWithoutSpringGivesNothing) {
  std::mt19937_64 random(9);
  int held = 0;
  for (int trial = 0; trial < 400; ++trial) {
    ContactCase c(random, {6, 6, 3}, 1 + trial % 3, 0.1);
    c.Z_q[trial % 3] = 0.0;
    c.tau_8 = c.Z_q.cwiseProduct(VecA(c.W.transpose() * c.dx));
    Projection answer;
    const VecA tau = c.force(&answer);
    held += answer.contradicted ? 1 : 0;
    for (int i = 0; i < c.contacts.size(); ++i) {
      EXPECT_GE(c.out_of(i, tau), -c.slack(i) - 1e-9 * c.tau_8.norm()) << trial;
    }
  }
  EXPECT_GT(held, 100);
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
        VecA rival = tau + VecA(normal_matrix(random, sizes.n_a, 1)) * 0.3 * c.tau_8.norm();
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
  Eigen::Matrix2d J;
  J << 40.0, 1.0, -60.0, 1.0;  // levers of opposite sign: 1 N flexes one joint, extends the other
  const auto map = map_of(J, 1, Unit::kRadian);
  const VecA Z_q = VecA::Constant(1, 1500.0);
  const VecX dx = VecX::Constant(2, -0.1) - 0.02 * VecX::Unit(2, 0), x = VecX::Zero(2);
  const VecQ q = VecQ::Zero(2);
  Projection out;
  PerContact rule{ProjectionModel(*map)};
  rule.project(Probe{q, x, MatXQ(J), {&contacts}}, dx, dx, Z_q, true, out);
  EXPECT_EQ(out.q_star[0], 0.0);
  EXPECT_TRUE(out.contradicted);
  // A held proxy's joint angles that are displaced the same way are the same two contacts.
  rule.project(Probe{q, x, MatXQ(J)}, dx, dx, Z_q, true, out);
  EXPECT_EQ(out.q_star[0], 0.0);
  EXPECT_TRUE(out.contradicted);
}

TEST(PerContact, JointsDisplacedOppositelyAreOneWall) {
  Eigen::Matrix2d inverse;
  inverse << 40.0, 60.0, 1.0, -1.0;  // levers of the same sign
  const MatXQ J = inverse.inverse().eval();
  const auto map = map_of(J, 1, Unit::kRadian);
  const VecA Z_q = VecA::Constant(1, 1500.0);
  const VecQ q = VecQ::Zero(2);
  const VecX x = VecX::Zero(2), dx = (VecX(2) << 0.1, -0.05).finished();
  Projection linear, out;
  Renderer(RendererKind::kSubspaceLinear, ProjectionModel(*map))
      .project(Probe{q, x, J}, dx, dx, Z_q, true, linear);
  PerContact{ProjectionModel(*map)}.project(Probe{q, x, J}, dx, dx, Z_q, true, out);
  EXPECT_FALSE(out.contradicted);
  EXPECT_EQ(out.q_star[0], linear.q_star[0]);
}

/// The force is continuous while joints begin to be displaced, in either sense.
TEST(PerContact, HeldProxyMovesWithoutStep) {
  std::mt19937_64 random(31);
  const VecA Z_q = VecA::Constant(1, 1500.0);
  constexpr int kSteps = 20000;
  int held = 0;
  for (int line = 0; line < 60; ++line) {
    const int n = 2 + line % 3;
    const Eigen::MatrixXd A = normal_matrix(random, n, n);
    if (oracle::condition(A) > 20.0) continue;
    const auto map = map_of(A, 1, Unit::kRadian);
    PerContact rule{ProjectionModel(*map)};
    const VecX from = 0.02 * normal_matrix(random, n, 1), to = 0.02 * normal_matrix(random, n, 1);
    const VecQ q = VecQ::Zero(n);
    const VecX x = VecX::Zero(n);
    const double band = contact_band(ProjectionModel(*map));
    // Per step: tau_8's own change, and a share's over the band of depth and over that of leverage,
    // which a displacement of one band may turn.
    const double lever = levers(A, 1).norm(), step = (to - from).norm() / kSteps;
    const double largest = lever * step * (2.0 + 21.0 * std::max(from.norm(), to.norm()) / band);
    double before = 0.0;
    for (int k = 0; k <= kSteps; ++k) {
      const VecX dx = from + (to - from) * k / kSteps;
      Projection out;
      rule.project(Probe{q, x, MatXQ(A)}, dx, dx, Z_q, true, out);
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
    static const VecA Z_q = VecA::Constant(1, 50.0);
    const VecQ q = (VecQ(2) << 0.4, bend).finished();
    VecX tip = VecX::Zero(3);
    MatXQ J = MatXQ::Zero(3, 2);
    EXPECT_EQ(map->evaluate(q, tip, J), MapStatus::kOk);
    const VecX dx = 0.002 * tip.normalized();
    Renderer renderer(kind, *map);
    renderer.project(Probe{q, tip, J}, tip + dx, dx, Z_q, true, out);
    return Z_q[0] * (out.q_star[0] - q[0]);
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

/// 1000 crossings in 1 ms ticks at up to 0.8 rad/s, proxies up to 4 mm away in any direction, noise
/// of 0.1 mm in x.
TEST_F(StretchedElbow, CrossingsAreGentle) {
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  std::normal_distribution<double> normal;
  const auto map = arm();
  const VecA Z_q = VecA::Constant(1, 50.0);
  Projection out;
  for (int crossing = 0; crossing < 1000; ++crossing) {
    const VecA limit = VecA::Constant(1, 0.5 + 20.0 * any(random));
    const double speed = 0.1 + 0.7 * any(random), away = 0.001 + 0.003 * any(random);
    const double turned = 2.0 * std::numbers::pi * any(random);
    PerContact rule{ProjectionModel(*map)};
    double last = 0.0;
    for (double bend = -0.15; bend <= 0.15; bend += 1e-3 * speed) {
      const VecQ q = (VecQ(2) << turned, bend).finished();
      VecX tip = VecX::Zero(3);
      MatXQ J = MatXQ::Zero(3, 2);
      ASSERT_EQ(map->evaluate(q, tip, J), MapStatus::kOk);
      const VecX dx = away * tip.normalized();
      const auto torque = [&](const VecX& to) {
        rule.project(Probe{q, tip, J, {nullptr, &limit}}, tip + to, to, Z_q, true, out);
        return std::clamp(Z_q[0] * (out.q_star[0] - q[0]), -limit[0], limit[0]);
      };
      const double tau = torque(dx);
      if (bend > -0.15) {
        ASSERT_LE(std::abs(tau - last), 0.05 * limit[0]) << crossing << " " << bend;
      }
      last = tau;
      const VecX noise = 1e-4 * VecX(normal_matrix(random, 3, 1));
      if (std::abs(tau) > 0.1 * limit[0] && away > 0.0015) {
        ASSERT_GT(torque(VecX(dx + noise)) * tau, 0.0) << crossing << " " << bend;
      }
    }
  }
}

}  // namespace
}  // namespace haptic::core
