// core/METHOD.md#projection-algorithm, case B: the prior where J does not have full column rank.
// Cases 9b, 12, 25 of tests/report/STUDY.md#hard-cases.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/rendering/proxy_solver.hpp"
#include "tests/core/linear/random_matrix.hpp"
#include "tests/core/model/sample_maps.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/core/rendering/study_maps.hpp"
#include "tests/support/dense_oracle.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

using samples::gaussian;

const VecA kZ_q = two(1.0, 50.0);
const VecX kX = two(0.5, 0.9);
const samples::WideMap kWideMap{};

/// `Z`: a Z_q that couples; empty: it is diagonal.
ProjectionSettings with_prior(double mu, const VecQ& M_n, IterationLimits iteration = {},
                              const Eigen::MatrixXd& Z = {}) {
  ProjectionSettings settings;
  settings.prior = Prior{mu, M_n};
  settings.iteration = iteration;
  if (Z.size() > 0) settings.coupling = std::make_shared<const StiffnessCoupling>(Z);
  return settings;
}

constexpr IterationLimits kToTheEnd{400, 1e-15};

/// Work to the user around a circle of radius 0.15 about (.2, .1, .15) in the plane of q_i and q_j,
/// relative to the sum of its parts' amounts. `force(q, first)` gives tau_a.
template <typename Force>
double loop_work(int i, int j, Force force) {
  constexpr int kPoints = 1501;
  double work = 0.0, amount = 0.0;
  VecQ q, last_q;
  VecA tau, last_tau;
  for (int k = 0; k < kPoints; ++k) {
    const double phase = 2.0 * std::numbers::pi * k / (kPoints - 1);
    q = (VecQ(3) << .2, .1, .15).finished();
    q[i] += 0.15 * std::cos(phase);
    q[j] += 0.15 * std::sin(phase);
    tau = force(q, k == 0);
    if (k > 0) {
      const double part = 0.5 * (tau + last_tau).dot((q - last_q).head(2));
      work += part;
      amount += std::abs(part);
    }
    last_q = q;
    last_tau = tau;
  }
  return std::abs(work) / amount;
}

constexpr int kPlanes[3][2] = {{0, 1}, {0, 2}, {1, 2}};

/// tests/report/STUDY.md#curved-wide-map, also with a Z_q that couples.
TEST(Prior, NoCyclePumpsEnergy) {
  const Eigen::Matrix2d tied = (Eigen::Matrix2d() << 1.0, 4.0, 4.0, 50.0).finished();
  for (const auto& [mu, couples] : {std::pair{1e-3, false}, {0.1, false}, {0.1, true}}) {
    const Eigen::MatrixXd Z = couples ? tied : Eigen::Matrix2d(kZ_q.asDiagonal());
    const ProjectionModel model(
        kWideMap, with_prior(mu, VecQ::Ones(1), kToTheEnd, couples ? Z : Eigen::MatrixXd()));
    const VecA stiffness = couples ? model.coupling()->scene_stiffness() : kZ_q;
    for (const auto& plane : kPlanes) {
      Renderer renderer(RendererKind::kSubspaceExact, model);
      const double work = loop_work(plane[0], plane[1], [&](const VecQ& q, bool first) {
        const Projection out = projected(renderer, Instant(kWideMap, q, kX), stiffness, first);
        EXPECT_EQ(out.status, ProjectionStatus::kConverged);
        return VecA(Z * Eigen::VectorXd((out.q_star - q).head(2)));
      });
      EXPECT_LT(work, 1e-11) << "mu " << mu << ", plane " << plane[0] << plane[1];
    }
  }
}

/// The same circles with what core/METHOD.md#projection-algorithm forbids: the check above must be
/// able to fail.
TEST(Prior, LiveReferenceOrOtherMetricPumps) {
  for (const double mu : {1e-3, 0.1}) {
    const ProjectionModel model(kWideMap, with_prior(mu, VecQ::Ones(1), kToTheEnd));
    const auto pumped = [&](int i, int j, const VecQ& M) {
      ProxySolver solver(model);
      Projection out;
      return loop_work(i, j, [&](const VecQ& q, bool first) {
        solver.set_prior((mu * M).cwiseSqrt(), q);  // q_n^ref live
        const VecQ seed = first ? q : out.q_star;
        solver.solve(kX, seed, kZ_q, out);
        return VecA(kZ_q.cwiseProduct((out.q_star - q).head(2)));
      });
    };
    EXPECT_GT(pumped(1, 2, (VecQ(3) << 1.0, 50.0, 1.0).finished()), 0.1) << mu;
    for (const auto& plane : kPlanes) {
      EXPECT_GT(pumped(plane[0], plane[1], VecQ::Ones(3)), 0.1) << mu << plane[0] << plane[1];
    }
  }
}

/// tau_a = -dV/dq_a with V = 1/2 ||q*_a - q_a||^2_{Z_q} + storage, by differences.
TEST(Prior, ForceIsMinusTheEnergysGradient) {
  const ProjectionModel model(kWideMap, with_prior(0.05, VecQ::Constant(1, 3.0), kToTheEnd));
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> anywhere(-0.3, 0.3);
  for (int trial = 0; trial < 200; ++trial) {
    const VecQ q = (VecQ(3) << anywhere(random), anywhere(random), anywhere(random)).finished();
    SubspaceExact exact(model);
    bool first = true;
    VecA tau = VecA::Zero(2);
    const auto energy = [&](const VecQ& at) {
      const Projection out = projected(exact, Instant(kWideMap, at, kX), kZ_q, first);
      first = false;
      tau = spring_force(kWideMap.layout(), out, at, kZ_q);
      return 0.5 * tau.dot(tau.cwiseQuotient(kZ_q)) + out.storage;
    };
    energy(q);  // q_n^ref = q_n from here on
    for (int i = 0; i < 2; ++i) {
      constexpr double h = 1e-5;
      VecQ up = q, down = q;
      up[i] += h;
      down[i] -= h;
      const double slope = (energy(up) - energy(down)) / (2.0 * h);
      energy(q);
      ASSERT_NEAR(-slope, tau[i], 1e-6 * (1.0 + std::abs(tau[i])));
    }
  }
}

/// On a linear map the minimum is a linear system, written out here. Every third Z_q couples.
TEST(Prior, LinearMapSolvesTheNormalEquations) {
  std::mt19937_64 random(4);
  for (int trial = 0; trial < 700; ++trial) {
    const int n_x = 1 + trial % 4, n_q = 2 + trial % 5, n_a = 1 + trial % (n_q - 1);
    const bool couples = trial % 3 == 0;
    const Eigen::MatrixXd A = gaussian(random, n_x, n_q), root = gaussian(random, n_a, n_a + 3);
    const auto map = samples::linear_map(A, n_a);
    const double mu = std::pow(10.0, -trial % 4);
    const VecQ d = gaussian(random, n_q, 1).cwiseAbs() + Eigen::VectorXd::Constant(n_q, 0.1);
    Eigen::MatrixXd M = d.asDiagonal(), Z;
    if (couples) {
      Z = oracle::product(root, root.transpose());
      M.topLeftCorner(n_a, n_a) = Z = (0.5 * (Z + Z.transpose())).eval();
    }
    const ProjectionModel model(
        *map, with_prior(mu, d.tail(n_q - n_a), couples ? kToTheEnd : IterationLimits{}, Z));
    const VecA Z_q = couples ? model.coupling()->scene_stiffness() : VecA(d.head(n_a));
    const VecQ q0 = gaussian(random, n_q, 1), q1 = gaussian(random, n_q, 1);
    const VecX x = gaussian(random, n_x, 1);
    VecQ target = q1;
    target.tail(n_q - n_a) = q0.tail(n_q - n_a);
    const Eigen::MatrixXd normal = oracle::product(A.transpose(), A) + mu * M;
    const Eigen::VectorXd want =
        target + oracle::inverse(normal) * (A.transpose() * (x - A * target));
    for (const RendererKind kind : {RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact}) {
      Renderer renderer(kind, model);
      projected(renderer, Instant(*map, q0, x), Z_q);
      // q_n^ref stays that of q0.
      const Projection out = projected(renderer, Instant(*map, q1, x), Z_q, false);
      ASSERT_LT((out.q_star - want).norm(), 1e-9 * (1.0 + want.norm()) / mu) << name(kind);
    }
  }
}

/// core/METHOD.md#rank-and-prior: Z_q S (A + mu M)^{-1} A S^T is symmetric and positive
/// semidefinite for every J, mu.
TEST(Prior, TheRenderedStiffnessIsPositiveSemidefinite) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> decade(-3.0, 3.0);
  for (int trial = 0; trial < 1000; ++trial) {
    const int n_x = 1 + trial % 3, n_q = 4;
    const auto map = samples::linear_map(gaussian(random, n_x, n_q), 2, 1e9);
    const VecA Z_q = two(std::pow(10.0, decade(random)), std::pow(10.0, decade(random)));
    const ProjectionModel model(*map, with_prior(std::pow(10.0, decade(random)), VecQ::Ones(2)));
    SubspaceLinear linear(model);
    Eigen::Matrix2d K;  // -d tau_a / dq_a, x and q_n held
    VecA tau_0;
    for (int column = -1; column < 2; ++column) {
      VecQ q = VecQ::Zero(n_q);
      if (column >= 0) q[column] = 1.0;
      const Projection out = projected(linear, Instant(*map, q, VecX::Zero(n_x)), Z_q, column < 0);
      const VecA tau = spring_force(map->layout(), out, q, Z_q);
      if (column < 0) {
        tau_0 = tau;
      } else {
        K.col(column) = tau_0 - tau;
      }
    }
    const double size = K.norm();
    ASSERT_LT((K - K.transpose()).norm(), 1e-9 * size + 1e-12);
    const Eigen::Matrix2d even = 0.5 * (K + K.transpose());
    ASSERT_GE(oracle::smallest_eigenvalue(even), -1e-9 * size - 1e-12);
    // Never stiffer than the actuators' own springs.
    const Eigen::Matrix2d left = Eigen::Matrix2d(Z_q.asDiagonal()) - even;
    ASSERT_GE(oracle::smallest_eigenvalue(left), -1e-9 * Z_q.norm());
  }
}

TEST(Prior, UnseenDirectionHasNoForce) {
  // The second actuator moves nothing in X.
  const auto map = samples::linear_map(Eigen::RowVector2d(1.0, 0.0), 2, 10.0);
  const ProjectionModel model(*map, with_prior(0.01, VecQ()));
  for (const RendererKind kind : {RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact}) {
    Renderer renderer(kind, model);
    for (double far : {0.0, 0.5, -3.0}) {
      const Instant at(*map, two(0.1, far), one(0.3));
      const Projection out = projected(renderer, at, kZ_q, far == 0.0);
      EXPECT_NEAR(out.q_star[1], far, 1e-12) << name(kind);
      EXPECT_GT(out.q_star[0], 0.25) << name(kind);
    }
  }
}

/// core/METHOD.md#hand-without-prior, and 3.2: without a prior the hand is refused, with one it is
/// calm.
TEST(Prior, PointsOfAHandNeedOne) {
  const auto hand = samples::hand_of_points(2), four = samples::hand_of_points(4);
  EXPECT_THROW(require_rank(ProjectionModel(*hand)), SceneError);
  EXPECT_NO_THROW(require_rank(ProjectionModel(*four)));  // its points do determine it
  // The weights of tests/report/STUDY.md#larger-devices: 0.1 per m of the wrist, 5 mm per rad
  // elsewhere.
  VecQ M_n(12);
  M_n << VecQ::Constant(3, 400.0), VecQ::Ones(9);
  const ProjectionModel model(*hand, with_prior(2.5e-5, M_n));
  EXPECT_NO_THROW(require_rank(model));

  std::mt19937_64 random(25);
  const VecA Z_q = VecA::Ones(2);
  const auto largest_step = [&](const ProjectionModel& by, const Instant& at) {
    Renderer renderer(RendererKind::kSubspaceLinear, by);
    const VecQ step = projected(renderer, at, Z_q).q_star - at.q;
    EXPECT_TRUE(step.allFinite());
    return step.cwiseAbs().maxCoeff();
  };
  double with = 0.0, without = 0.0;
  for (int trial = 0; trial < 300; ++trial) {
    const VecQ q = workspace_sample(*hand, trial);
    VecX x;
    ASSERT_EQ(hand->position(q, x), MapStatus::kOk);
    const Instant at(*hand, q, x + 0.003 * VecX(gaussian(random, 18, 1)));
    with = std::max(with, largest_step(model, at));
    without = std::max(without, largest_step(*hand, at));
  }
  EXPECT_LT(with, 1.0);     // rad: 3 mm at a phalanx of 20 mm is 0.15 rad
  EXPECT_GT(without, 5.0);  // what the refusal is for
  RecordProperty("with", std::to_string(with));
  RecordProperty("without", std::to_string(without));
}

TEST(Prior, RefusesWrongSizes) {
  EXPECT_THROW(require_rank(ProjectionModel(kWideMap)), SceneError);
  EXPECT_NO_THROW(require_rank(ProjectionModel(kWideMap, with_prior(0.1, VecQ::Ones(1)))));
  EXPECT_THROW(ProjectionModel(kWideMap, with_prior(0.1, VecQ::Ones(2))), SceneError);
  EXPECT_THROW(ProjectionModel(kWideMap, with_prior(0.1, VecQ::Zero(1))), SceneError);
  EXPECT_THROW(ProjectionModel(kWideMap, with_prior(0.0, VecQ::Ones(1))), SceneError);
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  EXPECT_NO_THROW(require_rank(ProjectionModel(*finger)));
  EXPECT_THROW(ProjectionModel(*finger, with_prior(0.1, VecQ::Ones(1))), SceneError);
}

}  // namespace
}  // namespace haptic::core
