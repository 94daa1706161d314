// core/METHOD.md#actuator-limits and core/METHOD.md#energy-tank: the potential of springs that are
// saturated each by itself, and of one whose Z_q is coupled, saturated as a whole.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "haptic/core/passivity/passivity_observer.hpp"
#include "haptic/core/passivity/spring_storage.hpp"
#include "tests/core/linear/random_matrix.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::core {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using samples::gaussian;

struct Spring {
  SpringStorage storage{};
  MatrixXd Z{};
  int weakest{-1};
};

/// Three DoFs of some 100 to 2000 N/m, limits of 1 to 6 N, gain 0.8. Not `coupled`: each for
/// itself.
Spring random_spring(std::mt19937_64& random, bool coupled = true) {
  std::uniform_real_distribution<double> limit(1.0, 6.0), size(100.0, 1000.0);
  Spring spring;
  const MatrixXd root = gaussian(random, 3, 4);
  spring.Z = size(random) * oracle::product(root, root.transpose());
  spring.Z = (0.5 * (spring.Z + spring.Z.transpose())).eval();
  spring.storage.stiffness = spring.Z.diagonal();
  spring.storage.gain = 0.8;
  spring.storage.limit = (VecA(3) << limit(random), limit(random), limit(random)).finished();
  if (!coupled) return spring;
  spring.storage.Z_q = spring.Z;
  spring.weakest = spring.storage.hold_within(VecA(spring.storage.limit));
  return spring;
}

VecA deviation(std::mt19937_64& random, double size) {
  return size * VecA(gaussian(random, 3, 1));
}

TEST(SpringStorage, SeparateSpringsAreQuadraticThenLinear) {
  SpringStorage s;
  s.stiffness = (VecA(3) << 1000.0, 50.0, 0.0).finished();
  s.limit = (VecA(3) << 4.0, 1.0, 2.0).finished();
  s.gain = 0.5;
  const auto energy = [&s](double a, double c) {
    return s.energy((VecA(3) << a, 0.0, c).finished());
  };
  EXPECT_DOUBLE_EQ(energy(0.002, 0.0), 0.5 * 0.5 * 1000.0 * 4e-6);
  // Saturates at 4 mm: 8 mJ up to there, 4 N over the further 6 mm.
  EXPECT_DOUBLE_EQ(energy(-0.010, 0.0), 0.5 * (0.008 + 4.0 * 0.006));
  EXPECT_EQ(energy(0.0, 5.0), 0.0) << "no stiffness stores nothing";
  s.gain = 0.0;
  EXPECT_EQ(s.scale_to(VecA::Ones(3), 0.0), 1.0) << "a spring without gain costs nothing";
}

TEST(SpringStorage, ForceIsItsEnergysGradient) {
  std::mt19937_64 random(1);
  int beyond = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const SpringStorage s = random_spring(random, trial % 3 != 0).storage;
    const VecA d = deviation(random, trial % 2 == 0 ? 1e-3 : 1e-2);
    beyond += trial % 3 != 0 && s.length(d) > s.radius ? 1 : 0;
    constexpr double h = 1e-7;
    for (int i = 0; i < 3; ++i) {
      VecA up = d, down = d;
      up[i] += h;
      down[i] -= h;
      EXPECT_NEAR(s.force(d)[i], (s.energy(up) - s.energy(down)) / (2 * h), 2e-5 * 6.0);
      EXPECT_LE(std::abs(s.force(d)[i]), s.gain * s.limit[i]);
    }
  }
  EXPECT_GT(beyond, 300);
  EXPECT_LT(beyond, 900);
}

TEST(SpringStorage, ScalingSpendsExactlyTheEnergyGiven) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  for (int trial = 0; trial < 3000; ++trial) {
    const SpringStorage s = random_spring(random, trial % 3 != 0).storage;
    const VecA d = deviation(random, trial % 2 == 0 ? 1e-3 : 2e-2);
    const double energy = share(random) * s.energy(d);
    const double scale = s.scale_to(d, energy);
    ASSERT_GE(scale, 0.0);
    ASSERT_LT(scale, 1.0);
    EXPECT_NEAR(s.energy(VecA(scale * d)), energy, 1e-14);
    EXPECT_EQ(s.scale_to(d, s.energy(d)), 1.0);
    EXPECT_EQ(s.scale_to(d, 0.0), 0.0);
    EXPECT_EQ(s.scale_to(d, -1e-3), 0.0);
  }
}

/// The formulas of core/METHOD.md#actuator-limits, written out.
TEST(CoupledSpring, IsLinearWithinItsRadius) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 500; ++trial) {
    const Spring spring = random_spring(random);
    const SpringStorage& s = spring.storage;
    const double r = (VectorXd(s.limit).array() / spring.Z.diagonal().array().sqrt()).minCoeff();
    EXPECT_NEAR(s.radius, r, 1e-12 * r);
    const VectorXd d = deviation(random, 5e-3);
    const double L = std::sqrt(d.dot(spring.Z * d));
    const VectorXd expected = 0.8 * std::min(1.0, r / L) * (spring.Z * d);
    EXPECT_LT((VectorXd(s.force(VecA(d))) - expected).norm(), 1e-11);
    const double V = L <= r ? 0.5 * L * L : r * L - 0.5 * r * r;
    EXPECT_NEAR(s.energy(VecA(d)), 0.8 * V, 1e-13);
  }
}

TEST(CoupledSpring, NoComponentPassesItsLimit) {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 300; ++trial) {
    const Spring spring = random_spring(random);
    const SpringStorage& s = spring.storage;
    for (int i = 0; i < 100; ++i) {
      const VecA tau = s.force(deviation(random, 1.0));
      for (int k = 0; k < 3; ++k) ASSERT_LE(std::abs(tau[k]), s.gain * s.limit[k]);
    }
    // Cauchy-Schwarz is met with equality along its own axis.
    ASSERT_GE(spring.weakest, 0);
    const VecA tau = s.force(VecA(VecA::Unit(3, spring.weakest)));
    EXPECT_NEAR(tau[spring.weakest], s.gain * s.limit[spring.weakest], 1e-11);
    EXPECT_LE(tau[spring.weakest], s.gain * s.limit[spring.weakest]) << "not even by rounding";
  }
}

TEST(CoupledSpring, ZeroStiffnessOrForceStoresNothing) {
  SpringStorage s;
  s.Z_q = MatAA::Zero(2, 2);
  s.gain = 1.0;
  EXPECT_EQ(s.hold_within(VecA::Ones(2)), -1);
  EXPECT_EQ(s.energy(VecA::Ones(2)), 0.0);
  EXPECT_EQ(s.force(VecA::Ones(2)).norm(), 0.0);
  s.Z_q = (MatAA(2, 2) << 4.0, 1.0, 1.0, 9.0).finished();
  s.hold_within(VecA::Zero(2));  // a session may take all force away
  EXPECT_EQ(s.energy(VecA::Ones(2)), 0.0);
  EXPECT_EQ(s.force(VecA::Ones(2)).norm(), 0.0);
  EXPECT_EQ(s.scale_to(VecA::Ones(2), 0.0), 1.0);
}

/// core/METHOD.md#passivity-observer: -alpha Z_q v takes what is missing in one tick, and alpha is
/// bounded by the inertia.
TEST(CoupledSpring, ObserversDampingTakesTheMissingEnergy) {
  constexpr double kTick = 1e-3;
  std::mt19937_64 random(8);
  for (int trial = 0; trial < 200; ++trial) {
    const Spring spring = random_spring(random);
    ObserverSettings settings;
    settings.enabled = true;
    settings.inertia = (VecA(3) << 0.5, 2.0, 1.0).finished();
    const VecA dq = deviation(random, 1e-4);
    const MatAA Z_q = spring.Z;
    PassivityObserver observer(settings, 3);
    HoldAccount account;
    account.leak = 1e-9;
    observer.observe(account, dq, kTick, {.Z_q = Z_q});
    EXPECT_NEAR(-observer.tau().dot(dq), 1e-9, 1e-20) << "over a tick of the same motion";
    EXPECT_LT((observer.tau() + observer.alpha() * VecA(spring.Z * VectorXd(dq)) / kTick).norm(),
              1e-12);

    account.leak = 1.0;  // far more than may be taken at once
    observer.observe(account, dq, kTick, {.Z_q = Z_q});
    const VectorXd root = VectorXd(settings.inertia).cwiseSqrt().cwiseInverse();
    const MatrixXd relative = root.asDiagonal() * spring.Z * root.asDiagonal();
    const double bound = 1.0 / (2.0 * kTick * oracle::singular_values(relative)[0]);
    EXPECT_LE(observer.alpha(), bound * (1.0 + 1e-12));
    EXPECT_GE(observer.alpha(), bound / std::sqrt(3.0)) << "but near it";
  }
}

}  // namespace
}  // namespace haptic::core
