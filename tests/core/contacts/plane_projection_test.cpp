#include "haptic/core/contacts/plane_projection.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>
#include <vector>

#include "tests/core/contacts/told_planes.hpp"
#include "tests/support/solved_contacts.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

/// Rows of (normal..., offset).
PlaneSet planes_in(int n_x, const std::vector<std::vector<double>>& rows) {
  PlaneSet set = planes_of(n_x, static_cast<int>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    set.normals.col(column) = Eigen::Map<const Eigen::VectorXd>(rows[i].data(), n_x);
    set.offsets[column] = rows[i].back();
  }
  return set;
}

struct Answer {
  VecX x{};
  PlaneStatus status{};
  std::uint32_t active{};
};

Answer project(const PlaneSet& set, const VecX& probe, const TaskMetric& metric = {}) {
  const ConfigurationSpace space = line_space(static_cast<int>(probe.size()));
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
      // x <= 0 and x >= 1: the middle, whatever the probe's x; its y is not touched.
      {"contradict", {{1, 0, 0}, {-1, 0, -1}}, two(.2, 2), kInfeasible, kAny, two(.5, 2), 1e-5},
      {"from afar", {{1, 0, 0}, {-1, 0, -1}}, two(4, 2), kInfeasible, kAny, two(.5, 2), 1e-5},
  };
  for (const Case& c : cases) {
    const Answer answer = project(planes_in(2, c.planes), c.probe, c.metric);
    EXPECT_EQ(answer.status, c.status) << c.what;
    EXPECT_LE((answer.x - c.x).norm(), c.within) << c.what << ": " << answer.x.transpose();
    if (c.active != kAny) {
      EXPECT_EQ(answer.active, c.active) << c.what;
    }
  }
}

TEST(PlaneProjection, CountsAnglesFromTheLinearisation) {
  const ConfigurationSpace circle({{"phi", Unit::kRadian, CoordinateKind::kAngle}});
  PlaneProjection projection(circle);
  projection.set(planes_in(1, {{1, 3.1}}), VecX::Constant(1, 3.1));
  VecX x;
  // -3.1 is 0.083 rad past 3.1, the short way round.
  EXPECT_EQ(projection.project(VecX::Constant(1, -3.1), x), PlaneStatus::kActive);
  EXPECT_NEAR(std::remainder(x[0] - 3.1, 2.0 * M_PI), 0.0, 1e-12);
}

TEST(PlaneProjection, ThirtyTwoPlanesAgreeWithSweeps) {
  std::mt19937 random(13);
  std::normal_distribution<double> normal(0.0, 1.0);
  int held = 0;
  for (int n = 0; n < 60; ++n) {
    const int n_x = 2 + n % 11;
    PlaneSet set = planes_of(n_x, kMaxPlanes);
    set.compliance.setZero(kMaxPlanes);
    VecX probe(n_x);
    fill(probe, [&] { return 2.0 * normal(random); });
    fill(set.normals, [&] { return normal(random); });
    fill(set.offsets, [&] { return 0.3 + std::abs(normal(random)); });
    const Answer got = project(set, probe);
    ASSERT_NEAR((got.x - haptic::test::solved(set, probe)).norm(), 0.0, 1e-6) << n;
    held += std::popcount(got.active);
  }
  EXPECT_GT(held, 100);
}

/// It begins with the planes that held the probe before; the answer must not depend on them.
TEST(PlaneProjection, ItsPastDoesNotMatter) {
  std::mt19937 random(14);
  std::normal_distribution<double> normal(0.0, 1.0);
  const int n_x = 6;
  PlaneSet set = planes_of(n_x, 20);
  set.offsets.setConstant(0.5);
  fill(set.normals, [&] { return normal(random); });
  const ConfigurationSpace space = line_space(n_x);
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

TEST(PlaneProjection, ExtremeNumbersKeepTheProxyFinite) {
  std::mt19937 random(1);
  const auto choose = [&](int n) {
    return static_cast<int>(random() % static_cast<std::uint32_t>(n));
  };
  const ConfigurationSpace space = line_space(2);
  PlaneProjection projection(space);
  const VecX probe = two(0.01, 0.01);
  for (int i = 0; i < 20'000; ++i) {
    PlaneSet set = planes_of(2, 2);
    set.curvature.resize(6);
    for (int k = 0; k < 2; ++k) {
      set.normals(0, k) = std::pow(10.0, -choose(101)) * (choose(2) == 0 ? 1.0 : -1.0);
      set.normals(1, k) = set.normals(0, k) * (choose(3) - 1);
      set.offsets[k] = choose(2) == 0 ? -1e9 : 1e6;
      set.curved[static_cast<std::size_t>(k)] = 2;
      for (int h = 0; h < 3; ++h) set.curvature[3 * k + h] = choose(2) == 0 ? -1e9 : 1e3;
    }
    projection.set(set, two(0, 0));
    for (int tick = 0; tick < 3; ++tick) {
      ASSERT_TRUE(led_to(projection, probe).allFinite()) << i;
      ASSERT_TRUE(std::isfinite(projection.stored())) << i;
    }
  }
}

}  // namespace
}  // namespace haptic::core
