// Eq. (39) against brute force (core/METHOD.md#error-bound): the truth is anything that the told
// uncertainty allows, solved here by other means.
#include <gtest/gtest.h>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/core/contacts/round_bodies.hpp"
#include "tests/core/contacts/told_planes.hpp"
#include "tests/support/percentile.hpp"
#include "tests/support/solved_contacts.hpp"

namespace haptic::core::proxy_error_test {
namespace {

double uniform(std::mt19937& random, double lowest, double highest) {
  return std::uniform_real_distribution<double>(lowest, highest)(random);
}

/// Figures by which a bound is judged.
struct Judged {
  std::vector<double> errors{}, bounds{};
  std::vector<double> depths{}, turns{};  ///< of the contacts, bound by error
  double peak{0.0};                       ///< of ||x - x_probe||
  int unknown{0}, taken{0};

  void take(const PlaneProjection& projection, const VecX& x_probe, const VecX& x,
            const VecX& truth, double rounding = 1e-8) {
    ProxyError error;
    projection.error(0.0, error);
    ++taken;
    peak = std::max(peak, (x - x_probe).norm());
    if (!error.known) {
      ++unknown;
      return;
    }
    const double bound = error.everywhere + (error.of.size() > 0 ? error.of.sum() : 0.0);
    const double off = (x - truth).norm();
    ASSERT_LE(off, bound + rounding);
    if (off <= rounding) return;
    errors.push_back(off);
    bounds.push_back(bound);
  }
  /// Contact i against the simulation's own: its direction and how deep the probe is beyond it.
  void take_contact(const PlaneProjection& projection, int i, const VecX& into, double depth) {
    if (projection.active() == 0) return;
    ProxyError error;
    projection.error(0.0, error);
    if (!error.known) return;
    const Contacts& used = projection.contacts();
    const bool told = error.depth.size() > 0;
    const double off = std::abs(used.depth[i] - depth);
    const double turned = (used.into.col(i) - into).norm();
    ASSERT_LE(off, (told ? error.depth[i] : 0.0) + 1e-8) << i;
    ASSERT_LE(turned, (error.turn.size() > 0 ? error.turn[i] : 0.0) + 1e-8) << i;
    if (off > 1e-8) depths.push_back(error.depth[i] / off);
    if (turned > 1e-8) turns.push_back(error.turn[i] / turned);
  }
  /// The median of the bounds by what it may be: 5 times that of the errors, or 1 % of the peak.
  [[nodiscard]] double loose() const {
    return test::percentile(bounds, 0.5) /
           std::max(5.0 * test::percentile(errors, 0.5), 0.01 * peak);
  }
};

/// Contacts, told right but for their stiffness, and a probe that walks about.
Judged walk(int n_x, int most, double u, double softest, std::uint32_t seed) {
  std::mt19937 random(seed);
  const ConfigurationSpace space = line_space(n_x);
  PlaneProjection projection(space);
  Judged judged;
  for (int run = 0; run < 300; ++run) {
    const int count = 1 + static_cast<int>(random() % static_cast<unsigned>(most));
    PlaneSet truth = planes_of(n_x, count);
    truth.compliance.resize(count);
    for (int i = 0; i < count; ++i) {
      for (int k = 0; k < n_x; ++k) truth.normals(k, i) = uniform(random, -1.0, 1.0);
      truth.offsets[i] = uniform(random, -0.2, 1.0) * truth.normals.col(i).norm();
      truth.compliance[i] = std::pow(10.0, uniform(random, softest, 1.5));
    }
    PlaneSet told = truth;
    told.uncertainty.setConstant(count, u);
    for (int i = 0; i < count; ++i) told.compliance[i] *= 1.0 + uniform(random, -u, u);
    VecX p(n_x);
    for (int k = 0; k < n_x; ++k) p[k] = uniform(random, -1.0, 2.0);
    projection.set(told, haptic::test::solved(truth, p), &p);
    for (int step = 0; step < 20; ++step) {
      for (int k = 0; k < n_x; ++k) p[k] += uniform(random, -0.1, 0.1);
      const VecX x = led_to(projection, p);
      judged.take(projection, p, x, haptic::test::solved(truth, p));
      for (int i = 0; i < count; ++i) {
        const VecX n = truth.normals.col(i);
        judged.take_contact(projection, i, n.normalized(),
                            (n.dot(p) - truth.offsets[i]) / n.norm());
      }
      if (testing::Test::HasFatalFailure()) return judged;
    }
  }
  EXPECT_EQ(judged.unknown, 0);
  return judged;
}

TEST(ProxyError, BoundsWrongStiffnesses) {
  for (const double u : {0.1, 0.3, 0.5, 0.9}) {
    for (const int n_x : {1, 2, 3}) {
      for (const int most : {1, 6}) {
        const Judged judged =
            walk(n_x, most, u, most == 1 ? -2.0 : -1.0, static_cast<std::uint32_t>(n_x));
        ASSERT_GT(judged.errors.size(), 100u);
        EXPECT_LT(judged.loose(), (u <= 0.5 ? 1.0 : 2.5) * (most == 1 ? 0.4 : 1.0))
            << u << ", " << n_x;
      }
    }
  }
}

/// Bodies by which a point is held off.
using Gaps = std::vector<round_bodies::Body>;

/// argmin 1/2 |x - p|^2 + 1/2 sum max(0, -phi)^2 / gamma, by many small steps.
Eigen::Vector2d settled(const Gaps& gaps, const std::vector<double>& gamma,
                        const Eigen::Vector2d& p) {
  Eigen::Vector2d x = p;
  for (int step = 0; step < 400; ++step) {
    Eigen::Vector2d slope = x - p;
    Eigen::Matrix2d M = Eigen::Matrix2d::Identity();
    for (std::size_t i = 0; i < gaps.size(); ++i) {
      const round_bodies::Jet gap = gaps[i](x);
      if (gap.phi >= 0.0) continue;
      slope += gap.phi / gamma[i] * gap.g;
      M += gap.g * gap.g.transpose() / gamma[i];
    }
    const Eigen::Vector2d moved = 0.7 * M.inverse() * slope;
    x -= moved;
    if (moved.norm() < 1e-14) break;
  }
  return x;
}

/// A probe that moves by up to `reach` since the anchor, for contacts that are told to the second
/// order; stiffnesses wrong by up to u.
Judged curved(const ConfigurationSpace& space, const Gaps& gaps, const Eigen::Vector2d& around,
              double spread, double reach, double u, double gamma, std::uint32_t seed) {
  std::mt19937 random(seed);
  PlaneProjection projection(space);
  Judged judged;
  for (int run = 0; run < 1000; ++run) {
    const Eigen::Vector2d start =
        around + spread * Eigen::Vector2d(uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0));
    std::vector<double> stiff(gaps.size());
    for (double& each : stiff) each = gamma * std::pow(10.0, uniform(random, -0.5, 0.5));
    const Eigen::Vector2d x_0 = settled(gaps, stiff, start);
    const auto count = static_cast<Eigen::Index>(gaps.size());
    PlaneSet told = planes_of(2, static_cast<int>(count));
    told.compliance.resize(count);
    told.curvature.resize(3 * count);
    told.uncertainty.setConstant(count, u);
    for (Eigen::Index i = 0; i < count; ++i) {
      const round_bodies::Jet gap = gaps[static_cast<std::size_t>(i)](x_0);
      told.normals.col(i) = -gap.g;
      told.offsets[i] = gap.phi - gap.g.dot(x_0);
      told.compliance[i] = stiff[static_cast<std::size_t>(i)] * (1.0 + uniform(random, -u, u));
      told.curvature.segment(3 * i, 3) << gap.H(0, 0), gap.H(1, 0), gap.H(1, 1);
      told.curved[static_cast<std::size_t>(i)] = 2;
    }
    const VecX used = start;
    projection.set(told, x_0, &used);
    const double way = uniform(random, 0.0, 2.0 * M_PI);
    for (int step = 1; step <= 20; ++step) {
      const VecX p = start + reach * step / 20.0 * Eigen::Vector2d(std::cos(way), std::sin(way));
      const VecX x = led_to(projection, p);
      const Eigen::Vector2d x_true = settled(gaps, stiff, p);
      judged.take(projection, p, x, x_true, 1e-7);
      for (int i = 0; i < static_cast<int>(count); ++i) {
        const round_bodies::Jet gap = gaps[static_cast<std::size_t>(i)](x_true);
        const double depth = -(gap.phi + gap.g.dot(p - x_true)) / gap.g.norm();
        judged.take_contact(projection, i, -gap.g.normalized(), depth);
      }
      if (testing::Test::HasFatalFailure()) {
        ADD_FAILURE() << run << " " << step << " " << u << " at " << start.transpose();
        return judged;
      }
    }
  }
  return judged;
}

TEST(ProxyError, BoundsADiscThatIsStroked) {
  const ConfigurationSpace space = line_space(2);
  const Gaps disc{[](const round_bodies::Coordinates& x) {
    return round_bodies::distance(Eigen::Matrix3d::Identity(), 0.030, 1.0, 1.0, {x[0], x[1], 0.0},
                                  Eigen::Matrix3d::Identity().leftCols(2));
  }};
  for (const double u : {0.0, 0.2}) {
    const Judged judged = curved(space, disc, {0.0, 0.028}, 0.006, 0.010, u, 1.0, 5);
    ASSERT_GT(judged.errors.size(), 1000u);
    EXPECT_LT(judged.loose(), u == 0.0 ? 0.3 : 0.8) << u;
    EXPECT_LT(judged.unknown, judged.taken / 5) << u;
  }
}

/// A point that two discs hold nearly from opposite sides. How they share its force is told only
/// within 20 %, and each part turns with its disc.
TEST(ProxyError, BoundsAPointBetweenDiscs) {
  Gaps discs;
  for (const double side : {-1.0, 1.0}) {
    discs.emplace_back([side](const round_bodies::Coordinates& x) {
      return round_bodies::distance(Eigen::Matrix3d::Identity(), 0.030, 1.0, 1.0,
                                    {x[0] - 0.029 * side, x[1] - 0.001 * side, 0.0},
                                    Eigen::Matrix3d::Identity().leftCols(2));
    });
  }
  const Judged judged = curved(line_space(2), discs, {0.0, 0.0}, 0.004, 0.003, 0.2, 0.3, 7);
  ASSERT_GT(judged.errors.size(), 1000u);
  EXPECT_LT(judged.loose(), 3.0);
}

/// Four pads of a finger.
Gaps pads(double aside) {
  Gaps gaps;
  for (const auto& [l_1, l_2] :
       {std::pair{0.025, 0.0}, {0.040, 0.0}, {0.045, 0.012}, {0.045, 0.024}}) {
    gaps.push_back(
        round_bodies::pad({0.02, 0.045}, 0.030, 1.0, 1.0, {l_1, 0.0}, {l_2, 0.0}, aside));
  }
  return gaps;
}

ConfigurationSpace finger(double link) {
  return ConfigurationSpace(
      {{.name = "a", .unit = Unit::kRadian, .link = link}, {.name = "b", .unit = Unit::kRadian}});
}

TEST(ProxyError, BoundsPadsOfAFinger) {
  const ConfigurationSpace space = finger(0.045);
  for (const double reach : {0.05, 0.2}) {
    for (const double u : {0.0, 0.2}) {
      const Judged judged = curved(space, pads(0.0), {0.45, 0.5}, 0.3, reach, u, 1e-3, 6);
      ASSERT_GT(judged.errors.size(), 1000u);
      EXPECT_LT(judged.loose(), u == 0.0 ? 0.1 : 1.2) << reach << ", " << u;
      EXPECT_LT(judged.unknown, judged.taken / 5) << reach << ", " << u;
    }
  }
}

TEST(ProxyError, BoundsSpheresAsideOfAFinger) {
  const Judged judged = curved(finger(0.045), pads(0.005), {0.45, 0.5}, 0.3, 0.2, 0.0, 1e-3, 6);
  ASSERT_GT(judged.errors.size(), 1000u);
  EXPECT_LT(judged.loose(), 0.5);
}

TEST(ProxyError, TrustsAFingersOwnLink) {
  const auto of = [](double link) {
    return test::percentile(
        curved(finger(link), pads(0.0), {0.45, 0.5}, 0.3, 0.05, 0.0, 1e-3, 6).bounds, 0.5);
  };
  const double none = of(0.0);
  EXPECT_LT(2.0 * of(0.045), none);
  EXPECT_EQ(of(0.050), none);
}

/// The normal of a round body that passes by turns, at a rate that nothing tells.
TEST(ProxyError, IsUnknownIfWhatCurvesMoves) {
  const ConfigurationSpace space = line_space(2);
  for (const double speed : {0.0, 0.01}) {
    for (const bool curves : {false, true}) {
      PlaneSet told = planes_of(2, 1);
      told.normals(1, 0) = -1.0;
      told.compliance = told.uncertainty = PlaneSet::Offsets::Zero(1);
      told.velocity = PlaneSet::Offsets::Constant(1, speed);
      told.curvature = PlaneSet::Curvatures::Zero(3);
      told.curvature[0] = curves ? 30.0 : 0.0;
      told.curved[0] = 2;
      PlaneProjection projection(space);
      const VecX used = Eigen::Vector2d(0.0, -0.001);
      projection.set(told, VecX::Zero(2), &used);
      static_cast<void>(led_to(projection, used));
      ProxyError error;
      projection.error(0.0, error);
      EXPECT_EQ(error.known, speed == 0.0 || !curves) << speed << " " << curves;
    }
  }
}

/// A notch between two discs that are deep in each other has other minima.
TEST(ProxyError, IsUnknownNextToAnotherMinimum) {
  const ConfigurationSpace space = line_space(2);
  for (const double deep : {0.0003, 0.02}) {
    PlaneSet told = planes_of(2, 2);
    const double cosine = 0.8, sine = 0.6, R = 0.03;
    told.normals << sine, -sine, -cosine, -cosine;
    told.compliance.setConstant(2, 0.01);
    told.uncertainty.setZero(2);
    told.curvature.resize(6);
    for (int i = 0; i < 2; ++i) {
      const double s = i == 0 ? sine : -sine;
      told.curvature.segment(3 * i, 3) << cosine * cosine / R, s * cosine / R, s * s / R;
      told.curved[static_cast<std::size_t>(i)] = 2;
    }
    PlaneProjection projection(space);
    const VecX used = Eigen::Vector2d(0.0, -deep);
    projection.set(told, VecX::Zero(2), &used);
    static_cast<void>(led_to(projection, used));
    ProxyError error;
    projection.error(0.0, error);
    EXPECT_EQ(error.known, deep < 0.01) << deep;
  }
}

TEST(ProxyError, IsNothingForExactContacts) {
  for (const int n_x : {1, 2, 3}) {
    const Judged judged = walk(n_x, 6, 0.0, -1.0, 11);
    for (const double bound : judged.bounds) ASSERT_LT(bound, 1e-5);
  }
}

}  // namespace
}  // namespace haptic::core::proxy_error_test
