// Other readers of a Z_q that is not diagonal: the prior (core/METHOD.md#projection-algorithm) and
// the displayed impedance, Eq. (9).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "haptic/core/error.hpp"
#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/core/model/stylus.hpp"
#include "haptic/core/rendering/renderer.hpp"
#include "tests/core/linear/random_matrix.hpp"
#include "tests/core/model/sample_hands.hpp"
#include "tests/core/rendering/function_map.hpp"
#include "tests/report/analysis/displayed_impedance.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::core {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using samples::FunctionMap;
using samples::gaussian;

const MatrixXd kZ = (Eigen::Matrix2d() << 1.0, 4.0, 4.0, 50.0).finished();
const VecX kTarget = (VecX(2) << 0.5, 0.9).finished();

ProjectionSettings coupled(const MatrixXd& Z) {
  ProjectionSettings settings;
  settings.coupling = std::make_shared<const StiffnessCoupling>(Z);
  return settings;
}

ProjectionSettings coupled_prior(const MatrixXd& Z, double mu, const VecQ& M_n) {
  ProjectionSettings settings = coupled(Z);
  settings.prior = Prior{mu, M_n};
  settings.iteration = {400, 1e-15};
  return settings;
}

/// tests/report/STUDY.md#curved-wide-map, with a Z_q that couples.
TEST(CoupledPrior, NoCyclePumpsEnergy) {
  const FunctionMap map = samples::wide_map();
  const ProjectionSettings settings = coupled_prior(kZ, 0.1, VecQ::Ones(1));
  const ProjectionModel model(map, settings);
  for (const auto& [i, j] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
    Renderer renderer(RendererKind::kSubspaceExact, model);
    constexpr int kPoints = 1501;
    double work = 0.0, amount = 0.0;
    VectorXd last_tau, last_q;
    for (int k = 0; k < kPoints; ++k) {
      const double phase = 2.0 * std::numbers::pi * k / (kPoints - 1);
      VecQ q = (VecQ(3) << .2, .1, .15).finished();
      q[i] += 0.15 * std::cos(phase);
      q[j] += 0.15 * std::sin(phase);
      VecX x_probe, dx;
      MatXQ J;
      static_cast<void>(map.evaluate(q, x_probe, J));
      map.space().difference(kTarget, x_probe, dx);
      Projection out;
      renderer.project(Probe{q, x_probe, J}, kTarget, dx, settings.coupling->scene_stiffness(),
                       k == 0, out);
      ASSERT_EQ(out.status, ProjectionStatus::kConverged);
      const VectorXd tau = kZ * VectorXd((out.q_star - q).head(2));
      const VectorXd q_a = q.head(2);
      if (k > 0) {
        const double part = 0.5 * (tau + last_tau).dot(q_a - last_q);
        work += part;
        amount += std::abs(part);
      }
      last_tau = tau;
      last_q = q_a;
    }
    EXPECT_LT(std::abs(work), 1e-11 * amount) << i << j;
  }
}

/// On a linear map the minimum is a linear system, written out here.
TEST(CoupledPrior, LinearMapSolvesTheNormalEquations) {
  std::mt19937_64 random(4);
  for (int trial = 0; trial < 200; ++trial) {
    const int n_x = 1 + trial % 4, n_q = 3 + trial % 3;
    const MatrixXd A = gaussian(random, n_x, n_q);
    const FunctionMap map(
        samples::dofs(n_q, 2, 1e6), samples::coordinates(n_x),
        [A](const VecQ& q) { return VecX(A * q); }, [A](const VecQ&) { return MatXQ(A); });
    const double mu = std::pow(10.0, -trial % 3);
    const MatrixXd root = gaussian(random, 2, 3);
    const MatrixXd Z = oracle::product(root, root.transpose());
    const VecQ M_n = VecQ::Constant(n_q - 2, 0.7);
    const ProjectionModel model(map, coupled_prior(0.5 * (Z + Z.transpose()), mu, M_n));
    const VecQ q = gaussian(random, n_q, 1);
    const VecX x = gaussian(random, n_x, 1);
    MatrixXd M = MatrixXd::Identity(n_q, n_q) * 0.7;
    M.topLeftCorner(2, 2) = Z;
    const MatrixXd normal = oracle::product(A.transpose(), A) + mu * M;
    const VectorXd want = q + oracle::inverse(normal) * (A.transpose() * (x - A * q));
    for (const RendererKind kind : {RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact}) {
      Renderer renderer(kind, model);
      Projection out;
      const MatXQ J = A;
      const VecX at = A * q, dx = x - at;
      renderer.project(Probe{q, at, J}, x, dx, model.coupling()->scene_stiffness(), true, out);
      ASSERT_LT((out.q_star - want).norm(), 1e-9 * (1.0 + want.norm()) / mu) << name(kind);
    }
  }
}

std::vector<ChainOutput> marks() {  // three points that are not in a line
  return {{"tip", "", OutputKind::kPoint, {{0.03, 0, 0}, {}}},
          {"end", "", OutputKind::kPoint, {{-0.10, 0, 0}, {}}},
          {"button", "", OutputKind::kPoint, {{0, 0, 0.03}, {}}}};
}

MatrixXd random_stiffness(std::mt19937_64& random) {
  const MatrixXd root = gaussian(random, 3, 4);
  const MatrixXd Z = 300.0 * oracle::product(root, root.transpose());
  return 0.5 * (Z + Z.transpose());
}

struct Pose {
  VecQ q{};
  VecX x_probe{}, dx{};
  MatXQ J{};
};

Pose pose(const Kinematics& map, int i, double far, std::mt19937_64& random) {
  Pose at;
  at.q = workspace_sample(map, i);
  EXPECT_EQ(map.evaluate(at.q, at.x_probe, at.J), MapStatus::kOk);
  std::uniform_real_distribution<double> shift(-far, far);
  at.dx = at.x_probe;
  for (double& x : at.dx) x = shift(random);
  return at;
}

/// Eq. (9) is -Z_q S, and the exact derivative that of what the renderers command.
TEST(CoupledImpedance, IsTheDerivativeOfTheForce) {
  const auto map = make_stylus({}, marks());
  std::mt19937_64 random(8);
  for (int i = 0; i < 20; ++i) {
    const MatrixXd Z = random_stiffness(random);
    const ProjectionSettings settings = coupled(Z);
    const VecA K = settings.coupling->scene_stiffness();
    RenderingImpedance impedance{K, MatXX::Identity(9, 9)};
    impedance.coupling = settings.coupling;
    const Pose at = pose(*map, i, 0.01, random);
    const VecX x = at.x_probe + at.dx;
    const MatrixXd theory =
        theoretical_impedance(RendererKind::kSubspaceLinear, *map, at.q, impedance).value();
    MatrixXd expected = MatrixXd::Zero(3, 6);
    expected.leftCols(3) = -Z;  // turntable, shoulder, elbow come first
    EXPECT_LT((theory - expected).norm(), 1e-12 * Z.norm());

    SubspaceLinear renderer{ProjectionModel(*map, settings)};
    const auto tau = [&](const VecQ& q) {
      VecX x_probe, dx;
      MatXQ J;
      EXPECT_EQ(map->evaluate(q, x_probe, J), MapStatus::kOk);
      map->space().difference(x, x_probe, dx);
      Projection out;
      renderer.project(Probe{q, x_probe, J}, {}, dx, K, true, out);
      return VectorXd(Z * VectorXd((out.q_star - q).head(3)));
    };
    const MatrixXd exact =
        exact_impedance(RendererKind::kSubspaceLinear, *map, at.q, x, impedance).value();
    const MatrixXd gain =
        proxy_gain(RendererKind::kSubspaceLinear, *map, at.q, x, at.q, impedance).value();
    for (int k = 0; k < 6; ++k) {
      constexpr double h = 1e-6;
      VecQ up = at.q, down = at.q;
      up[k] += h;
      down[k] -= h;
      EXPECT_LT(((tau(up) - tau(down)) / (2 * h) - exact.col(k)).norm(), 1e-6 * exact.norm());
    }
    EXPECT_LT((gain * VectorXd(at.dx) - tau(at.q)).norm(), 1e-9 * Z.norm()) << "linear in dx";
  }
}

TEST(CoupledModel, RefusesHandsAndOtherSizes) {
  const MatrixXd five = MatrixXd::Identity(5, 5) * 100.0 + MatrixXd::Ones(5, 5);
  const auto error_of = [](const Kinematics& map, const MatrixXd& Z) {
    try {
      const ProjectionModel model(map, coupled(Z));
    } catch (const SceneError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  const auto hand = make_hand_exoskeleton(five_fingers());
  EXPECT_NE(error_of(*hand, five).find("diagonal for a hand"), std::string::npos);
  EXPECT_NE(error_of(*make_stylus({}, marks()), five).find("one per actuated DoF, 3"),
            std::string::npos);
}

}  // namespace
}  // namespace haptic::core
