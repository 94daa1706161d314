// Properties over thousands of J with fixed seeds: full rank, nearly singular, singular,
// wide, mixed units. Forces are finite, bounded, zero at dx = 0, and do not know the units.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <random>

#include "tests/core/linear/random_matrix.hpp"
#include "tests/core/model/sample_maps.hpp"
#include "tests/core/rendering/every_renderer.hpp"

namespace haptic::core {
namespace {

using samples::gaussian;
using samples::with_condition;

enum class Family { kFullRank, kNearlySingular, kSingular, kWide, kMixedUnits };
constexpr Family kFamilies[] = {Family::kFullRank, Family::kNearlySingular, Family::kSingular,
                                Family::kWide, Family::kMixedUnits};

Eigen::MatrixXd draw(Family family, std::mt19937_64& random, int trial) {
  const int n = 2 + trial % 5, m = n + trial % 3;
  switch (family) {
    case Family::kFullRank:
      break;
    case Family::kNearlySingular:
      return with_condition(random, m, n, std::pow(10.0, 4.0 + trial % 13));
    case Family::kSingular: {
      Eigen::MatrixXd A = gaussian(random, m, n);
      if (trial % 3 == 0) A.col(trial % n).setZero();
      if (trial % 3 == 1) A.col(trial % n) = -3.0 * A.col((trial + 1) % n);
      if (trial % 3 == 2) A.row(trial % m).setZero();
      return A;
    }
    case Family::kWide:
      return gaussian(random, 1 + trial % (n - 1), n);
    case Family::kMixedUnits: {
      std::uniform_real_distribution<double> decade(-4.0, 4.0);
      Eigen::MatrixXd A = gaussian(random, m, n);
      for (int k = 0; k < n; ++k) A.col(k) *= std::pow(10.0, decade(random));
      return A;
    }
  }
  return gaussian(random, m, n);
}

struct Draw {
  std::unique_ptr<Kinematics> map{};
  Eigen::MatrixXd A{};
  VecQ q{};
  VecA Z_q{};
};

constexpr double kBox = 1e3;

Draw make_case(Family family, std::mt19937_64& random, int trial) {
  Draw c;
  c.A = draw(family, random, trial);
  const int n_q = static_cast<int>(c.A.cols()), n_a = 1 + trial % n_q;
  c.map = samples::linear_map(c.A, n_a, kBox);
  c.q = gaussian(random, n_q, 1);
  c.Z_q = VecA(gaussian(random, n_a, 1)).cwiseAbs() + VecA::Constant(n_a, 0.1);
  return c;
}

Projection project_draw(RendererKind kind, const ProjectionModel& model, const Draw& c,
                        const VecX& x) {
  Renderer renderer(kind, model);
  return projected(renderer, Instant(*c.map, c.q, x), c.Z_q);
}

ProjectionSettings draw_with_prior(const Draw& c) {
  ProjectionSettings settings;
  settings.prior = Prior{1e-3, VecQ::Ones(c.map->layout().n_n())};
  return settings;
}

/// J loses rank for certain.
bool is_singular(Family family, int trial) {
  return family == Family::kWide || (family == Family::kSingular && trial % 3 != 2);
}

class EveryJacobian : public testing::TestWithParam<Family> {};

TEST_P(EveryJacobian, FiniteForceAndNoneAtProbe) {
  std::mt19937_64 random(11);
  for (int trial = 0; trial < 1000; ++trial) {
    const Draw c = make_case(GetParam(), random, trial);
    const VecX at = c.A * c.q;
    const VecX x = at + VecX(gaussian(random, static_cast<int>(c.A.rows()), 1));
    for (const bool prior : {false, true}) {
      const ProjectionModel model(*c.map, prior ? draw_with_prior(c) : ProjectionSettings{});
      for (const RendererKind kind : kEveryRenderer) {
        ASSERT_TRUE(project_draw(kind, model, c, x).q_star.allFinite()) << name(kind) << "\n"
                                                                        << c.A;
        const Projection rest = project_draw(kind, model, c, at);
        // Rounding of x alone, through the worst direction that is not given up as lost.
        const double column = c.A.colwise().norm().minCoeff();
        const double blur = column > 0.0 ? 1e-15 * (1.0 + at.norm()) / column : 0.0;
        const double amplified = blur * std::min(1e8, std::max(10.0, rest.condition)) * 10.0;
        ASSERT_LE((rest.q_star - c.q).norm(), amplified + 1e-9) << name(kind) << "\n" << c.A;
      }
    }
  }
}

/// ||C^{-1} dq|| <= n cond ||dx|| / min ||J_k C_k|| = n cond ||dx||, the equilibrated columns being
/// of length 1; and cond is at most 1e8 where it counts. Eq. (6) ends in its box besides.
TEST_P(EveryJacobian, ReportedConditionBoundsTheForce) {
  std::mt19937_64 random(12);
  for (int trial = 0; trial < 1000; ++trial) {
    const Draw c = make_case(GetParam(), random, trial);
    const int n_q = static_cast<int>(c.A.cols());
    const VecX dx = gaussian(random, static_cast<int>(c.A.rows()), 1);
    const VecX x = c.A * c.q + dx;
    const ProjectionModel model(*c.map);
    const Projection linear = project_draw(RendererKind::kSubspaceLinear, model, c, x);
    if (linear.status == ProjectionStatus::kExact) {
      ASSERT_LE(linear.condition, 1e8);
      for (int k = 0; k < n_q; ++k) {
        const double moved = std::abs(linear.q_star[k] - c.q[k]) * c.A.col(k).norm();
        ASSERT_LE(moved, 10.0 * n_q * linear.condition * (dx.norm() + 1e-14)) << c.A;
      }
    } else {
      ASSERT_TRUE(linear.status == ProjectionStatus::kRankDeficient ||
                  linear.status == ProjectionStatus::kIllConditioned)
          << static_cast<int>(linear.status);
    }
    for (const RendererKind kind : {RendererKind::kNullSpace, RendererKind::kSubspaceLinear}) {
      if (!is_singular(GetParam(), trial)) continue;
      ASSERT_NE(project_draw(kind, model, c, x).status, ProjectionStatus::kExact) << c.A;
    }
    const Projection exact = project_draw(RendererKind::kSubspaceExact, model, c, x);
    ASSERT_LE(exact.q_star.cwiseAbs().maxCoeff(), kBox);
    ASSERT_LE(exact.residual, dx.norm() * (1.0 + 1e-9) + 1e-9) << "never worse than the seed";
  }
}

/// The prior's own bound: 1/2 ||q*_a - q_a||^2_{Z_q} <= ||dx||^2 / (2 mu), whatever J.
TEST_P(EveryJacobian, PriorsWeightBoundsTheForce) {
  std::mt19937_64 random(13);
  for (int trial = 0; trial < 1000; ++trial) {
    const Draw c = make_case(GetParam(), random, trial);
    const VecX dx = gaussian(random, static_cast<int>(c.A.rows()), 1);
    const ProjectionModel model(*c.map, draw_with_prior(c));
    for (const RendererKind kind : {RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact}) {
      const Projection out = project_draw(kind, model, c, c.A * c.q + dx);
      const VecA d = c.map->layout().select(out.q_star - c.q);
      ASSERT_LE(0.5 * d.dot(c.Z_q.cwiseProduct(d)), dx.squaredNorm() / 2e-3 * (1.0 + 1e-9));
    }
  }
}

/// tests/report/STUDY.md#change-of-units: metres or millimetres, radians or degrees, in Q and X,
/// the metric and Z_q in theirs; the same physical force.
TEST_P(EveryJacobian, ForceIgnoresTheUnits) {
  std::mt19937_64 random(14);
  const auto units = [](Eigen::Index n, double even, double odd) {
    Eigen::VectorXd per(n);
    for (Eigen::Index k = 0; k < n; ++k) per[k] = k % 2 == 0 ? even : odd;
    return per;
  };
  constexpr double kDegrees = 57.295779513082323;
  int judged = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const Draw c = make_case(GetParam(), random, trial);
    const VecX x = c.A * c.q + gaussian(random, static_cast<int>(c.A.rows()), 1);
    const VecQ per = units(c.A.cols(), 1e3, kDegrees);
    const VecX in_x = units(c.A.rows(), 1e3, 1e3), scale = units(c.A.rows(), 0.5, 2.0);
    const VecA in_a = c.map->layout().select(per);
    Draw other;
    other.A = in_x.asDiagonal() * c.A * per.cwiseInverse().asDiagonal();
    other.map = samples::linear_map(other.A, c.map->layout().n_a(), kBox * 1e3);
    other.q = c.q.cwiseProduct(per);
    other.Z_q = c.Z_q.cwiseQuotient(in_a.cwiseAbs2());
    ProjectionSettings plain, scaled;
    plain.metric = TaskMetric::from_scales(scale);
    scaled.metric = TaskMetric::from_scales(scale.cwiseProduct(in_x));
    const Projection one = project_draw(RendererKind::kSubspaceLinear, {*c.map, plain}, c, x);
    const Projection two = project_draw(RendererKind::kSubspaceLinear, {*other.map, scaled}, other,
                                        x.cwiseProduct(in_x));
    // Beyond, the status itself turns on rounding.
    if (GetParam() == Family::kNearlySingular && !(one.condition < 1e7)) continue;
    ASSERT_EQ(one.status, two.status);
    ++judged;
    const VecA tau = spring_force(c.map->layout(), one, c.q, c.Z_q);
    const VecA again = spring_force(c.map->layout(), two, other.q, other.Z_q).cwiseProduct(in_a);
    const double size = c.Z_q.norm() * (1.0 + c.q.norm() + (one.q_star - c.q).norm());
    const bool exact = one.status == ProjectionStatus::kExact;
    const double amplified = exact ? 1e-14 * std::max(1e2, one.condition) : 1e-10;
    ASSERT_LT((tau - again).norm(), 100.0 * amplified * size) << c.A;
  }
  EXPECT_GT(judged, GetParam() == Family::kNearlySingular ? 150 : 900);
}

std::string family_name(const testing::TestParamInfo<Family>& param) {
  constexpr const char* kNames[] = {"FullRank", "NearlySingular", "Singular", "Wide", "MixedUnits"};
  return kNames[static_cast<int>(param.param)];
}

INSTANTIATE_TEST_SUITE_P(Families, EveryJacobian, testing::ValuesIn(kFamilies), family_name);

}  // namespace
}  // namespace haptic::core
