#include "haptic/core/contacts/plane_projection.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

ConfigurationSpace space_of(int n_x) {
  return ConfigurationSpace(std::vector<Coordinate>(static_cast<std::size_t>(n_x)));
}

/// Rows of (normal..., offset).
PlaneSet planes_of(int n_x, const std::vector<std::vector<double>>& rows) {
  PlaneSet set;
  set.normals.resize(n_x, static_cast<Eigen::Index>(rows.size()));
  set.offsets.resize(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (int j = 0; j < n_x; ++j) {
      set.normals(j, static_cast<Eigen::Index>(i)) = rows[i][static_cast<std::size_t>(j)];
    }
    set.offsets[static_cast<Eigen::Index>(i)] = rows[i].back();
  }
  return set;
}

struct Answer {
  VecX x{};
  PlaneStatus status{};
  std::uint32_t active{};
};

Answer project(const PlaneSet& set, const VecX& probe, const TaskMetric& metric = {}) {
  const ConfigurationSpace space = space_of(static_cast<int>(probe.size()));
  PlaneProjection projection(space, metric);
  projection.set(set, VecX::Constant(probe.size(), 0.3));  // where it is linearised must not matter
  Answer answer;
  answer.status = projection.project(probe, answer.x);
  answer.active = projection.active();
  return answer;
}

/// Rows of planes, a probe, and where that leads.
struct Case {
  const char* what;
  std::vector<std::vector<double>> planes;
  VecX probe;
  PlaneStatus status;
  std::uint32_t active;  ///< as bits; kAny: rounding decides between copies
  VecX x;
  double within;
  TaskMetric metric{};
};
constexpr std::uint32_t kAny = ~0u;

TEST(PlaneProjection, LeadsWhereAlgebraDoes) {
  using enum PlaneStatus;
  const Eigen::Matrix2d tied = (Eigen::Matrix2d() << 2, 1, 1, 1).finished();
  const std::vector<Case> cases{
      {"none", {}, two(7, 8), kFree, 0, two(7, 8), 0},
      {"not reached", {{1, 0, 1}, {0, 1, 1}}, two(.1, .9999), kFree, 0, two(.1, .9999), 0},
      // 3 x + 4 y <= 5 seen from (3, 4): 4 beyond along (3, 4)/5.
      {"one", {{3, 4, 5}}, two(3, 4), kActive, 1, two(.6, .8), 1e-14},
      // min 4 (x-1)^2 + (y-1)^2 on x + y = 0: x - 1 = -2/5, y - 1 = -8/5.
      {"weighed",
       {{1, 1, 0}},
       two(1, 1),
       kActive,
       1,
       two(.6, -.6),
       1e-14,
       TaskMetric::from_scales(two(0.5, 1))},
      // min 2 u^2 + 2 u v + v^2 on u = -0.5 (v = y - 1): u + v = 0, v = 0.5.
      {"moves a tied coordinate",
       {{1, 0, .5}},
       two(1, 1),
       kActive,
       1,
       two(.5, 1.5),
       1e-14,
       TaskMetric::from_matrix(tied)},
      {"corner", {{1, 0, .2}, {0, 1, .3}}, two(1, 1), kActive, 3, two(.2, .3), 1e-14},
      {"parallel", {{1, 0, .5}, {2, 0, .4}}, two(1, 1), kActive, 2, two(.2, 1), 1e-13},
      {"copies",
       {{1, 0, .2}, {1, 0, .2}, {3, 0, .6}, {1, 1e-9, .2}, {1, 0, .2}, {1, 0, 9}},
       two(1, 1),
       kActive,
       kAny,
       two(.2, 1),
       1e-8},
      {"redundant",
       {{1, 0, .2}, {0, 1, .3}, {1, 1, .5}},
       two(1, 1),
       kActive,
       kAny,
       two(.2, .3),
       1e-12},
      {"in a slab", {{1, 0, .2}, {-1, 0, .1}}, two(.1, 5), kFree, 0, two(.1, 5), 0},
      {"right of it", {{1, 0, .2}, {-1, 0, .1}}, two(1, 5), kActive, 1, two(.2, 5), 1e-14},
      {"left of it", {{1, 0, .2}, {-1, 0, .1}}, two(-1, 5), kActive, 2, two(-.1, 5), 1e-14},
      {"a slab of no thickness",
       {{1, 0, .2}, {-1, 0, -.2}},
       two(1, 5),
       kActive,
       kAny,
       two(.2, 5),
       1e-6},
      {"without a direction", {{0, 0, -1}, {1, 0, .2}}, two(1, 1), kActive, 2, two(.2, 1), 1e-14},
      // Twice x <= 0 against once x >= 1: least squares of three violations.
      {"two against one",
       {{1, 0, 0}, {1, 0, 0}, {-1, 0, -1}},
       two(.4, 2),
       kInfeasible,
       kAny,
       two(1.0 / 3.0, 2),
       1e-5},
  };
  for (const Case& c : cases) {
    const Answer answer = project(planes_of(2, c.planes), c.probe, c.metric);
    EXPECT_EQ(answer.status, c.status) << c.what;
    EXPECT_LE((answer.x - c.x).norm(), c.within) << c.what << ": " << answer.x.transpose();
    if (c.active != kAny) {
      EXPECT_EQ(answer.active, c.active) << c.what;
    }
  }
}

TEST(PlaneProjection, ContradictingPlanesGiveTheLeastViolation) {
  // x <= 0 and x >= 1: the middle, whatever the probe's x; its y is not touched.
  for (const double from : {-3.0, 0.2, 0.5, 4.0}) {
    const Answer answer = project(planes_of(2, {{1, 0, 0}, {-1, 0, -1}}), two(from, 2));
    EXPECT_EQ(answer.status, PlaneStatus::kInfeasible);
    EXPECT_NEAR(answer.x[0], 0.5, 1e-5);
    EXPECT_NEAR(answer.x[1], 2.0, 1e-12);
  }
}

TEST(PlaneProjection, CountsAnglesFromTheLinearisation) {
  const ConfigurationSpace circle({{"phi", Unit::kRadian, CoordinateKind::kAngle}});
  PlaneProjection projection(circle);
  projection.set(planes_of(1, {{1, 3.1}}), VecX::Constant(1, 3.1));
  VecX x;
  // -3.1 is 0.083 rad past 3.1, the short way round.
  EXPECT_EQ(projection.project(VecX::Constant(1, -3.1), x), PlaneStatus::kActive);
  EXPECT_NEAR(std::remainder(x[0] - 3.1, 2.0 * M_PI), 0.0, 1e-12);
}

/// R. L. Dykstra's cyclic projections onto the planes, until nothing moves.
VecX dykstra(const PlaneSet& set, const VecX& probe) {
  VecX x = probe;
  Eigen::MatrixXd given = Eigen::MatrixXd::Zero(probe.size(), set.size());
  for (int sweep = 0; sweep < 20000; ++sweep) {
    double moved = 0.0;
    for (int i = 0; i < set.size(); ++i) {
      const VecX normal = set.normals.col(i), from = x + given.col(i);
      const double beyond = (normal.dot(from) - set.offsets[i]) / normal.squaredNorm();
      const VecX to = from - std::max(0.0, beyond) * normal;
      moved = std::max(moved, (to - x).norm());
      given.col(i) = from - to;
      x = to;
    }
    if (moved < 1e-13) break;
  }
  return x;
}

TEST(PlaneProjection, ThirtyTwoPlanesAgreeWithDykstra) {
  std::mt19937 random(13);
  std::normal_distribution<double> normal(0.0, 1.0);
  int held = 0;
  for (int n = 0; n < 60; ++n) {
    const int n_x = 2 + n % 11;
    PlaneSet set;
    set.normals.resize(n_x, kMaxPlanes);
    set.offsets.resize(kMaxPlanes);
    VecX probe(n_x);
    for (int j = 0; j < n_x; ++j) probe[j] = 2.0 * normal(random);
    for (int i = 0; i < kMaxPlanes; ++i) {
      for (int j = 0; j < n_x; ++j) set.normals(j, i) = normal(random);
      set.offsets[i] = 0.3 + std::abs(normal(random));
    }
    const Answer got = project(set, probe);
    ASSERT_NEAR((got.x - dykstra(set, probe)).norm(), 0.0, 1e-6) << n;
    for (int i = 0; i < kMaxPlanes; ++i) held += (got.active >> i & 1u) != 0 ? 1 : 0;
  }
  EXPECT_GT(held, 100);
}

/// It begins with the planes that held the probe before; the answer must not depend on them.
TEST(PlaneProjection, ItsPastDoesNotMatter) {
  std::mt19937 random(14);
  std::normal_distribution<double> normal(0.0, 1.0);
  const int n_x = 6;
  PlaneSet set;
  set.normals.resize(n_x, 20);
  set.offsets.setConstant(20, 0.5);
  for (double& entry : set.normals.reshaped()) entry = normal(random);
  const ConfigurationSpace space = space_of(n_x);
  PlaneProjection projection(space);
  projection.set(set, VecX::Constant(n_x, 0.3));
  VecX probe = VecX::Zero(n_x), x;
  for (int n = 0; n < 2000; ++n) {
    for (int j = 0; j < n_x; ++j) probe[j] += 0.1 * normal(random) - 0.02 * probe[j];
    const PlaneStatus status = projection.project(probe, x);
    const Answer fresh = project(set, probe);
    ASSERT_EQ(status, fresh.status) << n;
    ASSERT_NEAR((x - fresh.x).norm(), 0.0, 1e-11) << n;
    ASSERT_EQ(projection.active(), fresh.active) << n;
  }
}

TEST(PlaneProjection, AnyInputGivesABoundedAnswer) {
  std::mt19937 random(12);
  std::uniform_int_distribution<int> small(-1, 1);
  std::uniform_real_distribution<double> jitter(-1e-9, 1e-9);
  for (int n = 0; n < 5000; ++n) {
    std::vector<std::vector<double>> rows;
    for (int i = 0; i < kMaxPlanes; ++i) {
      const int x = small(random), y = small(random);
      // Nearly parallel, nearly opposite planes; a normal of the jitter alone would be a plane far
      // off.
      rows.push_back({x == 0 && y == 0 ? 1.0 : x + (n % 2) * jitter(random), y * 1.0,
                      small(random) * 0.5 + (n % 3) * jitter(random)});
    }
    const Answer answer = project(planes_of(2, rows), two(0.7, -0.4));
    ASSERT_TRUE(answer.x.allFinite()) << n;
    ASSERT_LT(answer.x.norm(), 10.0) << n;
  }
}

TEST(PlaneProjection, ExtremeNumbersKeepTheProxyFinite) {
  std::mt19937 random(1);
  const auto choose = [&](int n) {
    return static_cast<int>(random() % static_cast<std::uint32_t>(n));
  };
  const ConfigurationSpace space = space_of(2);
  PlaneProjection projection(space);
  const VecX probe = two(0.01, 0.01);
  for (int i = 0; i < 20'000; ++i) {
    PlaneSet set = planes_of(2, {{0, 0, 0}, {0, 0, 0}});
    set.curvature.resize(6);
    for (int k = 0; k < 2; ++k) {
      set.normals(0, k) = std::pow(10.0, -choose(101)) * (choose(2) == 0 ? 1.0 : -1.0);
      set.normals(1, k) = set.normals(0, k) * (choose(3) - 1);
      set.offsets[k] = choose(2) == 0 ? -1e9 : 1e6;
      set.curved[static_cast<std::size_t>(k)] = 2;
      for (int h = 0; h < 3; ++h) set.curvature[3 * k + h] = choose(2) == 0 ? -1e9 : 1e3;
    }
    projection.set(set, two(0, 0));
    VecX x;
    for (int tick = 0; tick < 3; ++tick) {
      static_cast<void>(projection.project(probe, x));
      ASSERT_TRUE(x.allFinite()) << i;
      ASSERT_TRUE(std::isfinite(projection.stored())) << i;
    }
  }
}

}  // namespace
}  // namespace haptic::core
