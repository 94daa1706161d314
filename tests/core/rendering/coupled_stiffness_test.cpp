// The displayed impedance, Eq. (9), of a Z_q that is not diagonal.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "haptic/core/error.hpp"
#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/core/model/stylus.hpp"
#include "haptic/core/rendering/renderer.hpp"
#include "tests/core/linear/random_matrix.hpp"
#include "tests/core/model/sample_hands.hpp"
#include "tests/report/analysis/displayed_impedance.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::core {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using samples::gaussian;

ProjectionSettings coupled(const MatrixXd& Z) {
  ProjectionSettings settings;
  settings.coupling = std::make_shared<const StiffnessCoupling>(Z);
  return settings;
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
