// g and H of a round body, against the body itself (core/METHOD.md#error-bound).
#include "haptic/core/contacts/round_gap.hpp"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/core/contacts/round_bodies.hpp"

namespace haptic::core::round_gap_test {
namespace {

using namespace round_bodies;

double between(std::mt19937& random, double lowest, double highest) {
  return std::uniform_real_distribution<double>(lowest, highest)(random);
}

RoundGap told(RoundGap::Moves moves, const Jet& jet) {
  std::vector<double> lower;
  for (int row = 0; row < jet.g.size(); ++row) {
    for (int column = 0; column <= row; ++column) lower.push_back(jet.H(row, column));
  }
  return {moves, static_cast<int>(jet.g.size()), jet.g.data(), lower.data()};
}

RoundGap::Off off(const RoundGap& round, const Eigen::VectorXd& z, const RoundGap::Law& law) {
  return round.moves() == RoundGap::Moves::kPoint ? round.point(z.data(), law)
                                                  : round.hinges(RoundGap::Turn(z.data()), law);
}

/// A point from a sphere or a cylinder, in 2 or 3 coordinates.
Body point(int n, const Vector3d& start, bool sphere, double outside, double scale) {
  Matrix3d across = Matrix3d::Identity();
  if (!sphere) across(0, 0) = 0.0;
  return [=](const Coordinates& x) {
    Vector3d p = start;
    p.tail(n) += x;  // in two coordinates: across the axis, or through the centre
    return distance(across, 0.03, outside, scale, p, Matrix3d::Identity().rightCols(n));
  };
}

/// The told law is off by what the body says, here and on every short way from here.
void expect_whole(RoundGap::Moves moves, const Body& body, double farthest, std::mt19937& random) {
  const auto n = body(Eigen::VectorXd::Zero(moves == RoundGap::Moves::kHinges ? 2 : 3)).g.size();
  const auto anywhere = [&random, n](double most) {
    Eigen::VectorXd v(n);
    for (double& part : v) part = between(random, -1.0, 1.0);
    return Eigen::VectorXd(v * most / std::sqrt(static_cast<double>(n)));
  };
  const Jet at = body(Eigen::VectorXd::Zero(n));
  const RoundGap round = told(moves, at);
  ASSERT_EQ(round.moves(), moves);
  for (int k = 0; k < 20; ++k) {
    const Eigen::VectorXd z = anywhere(farthest);
    const Jet there = body(z);
    const Eigen::VectorXd g = at.g + at.H * z;
    const double gap = at.g.dot(z) + 0.5 * z.dot(at.H * z);
    const RoundGap::Off is = off(round, z, {gap, g.data()});
    const double size = at.g.norm();
    ASSERT_NEAR(is.gap, std::abs(there.phi - at.phi - gap), 1e-9 * size);
    ASSERT_NEAR(is.gradient, (there.g - g).norm() / size, 1e-7);
    ASSERT_NEAR(is.bend, there.H.operatorNorm() / (size * size), 1e-5 * is.bend);
    const double most = 1.0 / is.grows / size;
    const Eigen::VectorXd way = anywhere(std::min(1.0, most));
    const Jet moved = body(z + way);
    const double far = size * way.norm();
    const Eigen::VectorXd turned = (moved.g - there.g - there.H * way) / size;
    ASSERT_LE(turned.norm(), 0.5 * is.third_within(far) * far * far * (1.0 + 1e-6) + 1e-9);
    ASSERT_LE(moved.H.operatorNorm() / (size * size), is.bend_within(far) * (1.0 + 1e-6));
  }
}

TEST(RoundGap, TellsADiscOfAPad) {
  std::mt19937 random(1);
  for (int run = 0; run < 2000; ++run) {
    const auto any = [&random](double most) {
      return Vector2d(between(random, -most, most), between(random, -most, most));
    };
    const Vector2d link = Vector2d(0.045, 0.0) + any(0.02);
    const Vector2d tip = Vector2d(0.02, -0.008) + any(0.006);
    const double way = between(random, 0.0, 2.0 * M_PI), s = between(random, 0.02, 0.2);
    const Vector2d normal(std::cos(way), std::sin(way));
    const double over = std::abs(normal.dot(tip)), over_link = std::abs(normal.dot(link));
    // No height over the second hinge, or as much over both: degenerate.
    if (over < 0.002 || over_link < 0.01) continue;
    const double outside = run % 2 == 0 ? 1.0 : -1.0, scale = between(random, 0.1, 10.0);
    const Body body = pad(link + tip - s * normal, s - 0.002, outside, scale, link, tip);
    const double rolls = std::abs(normal.dot(link + tip) / s - 1.0);  // H_11 - H_12
    if (run % 2 == 0 && rolls < 0.05) continue;
    expect_whole(RoundGap::Moves::kHinges, body, 0.2, random);
    if (testing::Test::HasFatalFailure()) FAIL() << run;
  }
}

TEST(RoundGap, TellsABodyOfAPoint) {
  std::mt19937 random(2);
  for (int run = 0; run < 500; ++run) {
    const Vector3d start(between(random, -0.02, 0.02), between(random, 0.02, 0.03),
                         between(random, 0.005, 0.02));
    const bool sphere = run % 2 == 0;
    const double outside = run % 4 < 2 ? 1.0 : -1.0, scale = between(random, 0.1, 10.0);
    const Body body = point(3, start, sphere, outside, scale);
    expect_whole(RoundGap::Moves::kPoint, body, 0.01, random);
    if (testing::Test::HasFatalFailure()) FAIL() << run;
  }
}

TEST(RoundGap, AWallStaysFlat) {
  const Eigen::Matrix2d none = Eigen::Matrix2d::Zero();
  const Vector2d link(0.04, 0.01), tip(0.02, -0.01);
  const Body wall = [&](const Coordinates& x) {  // y >= 0
    const Vector2d first = Eigen::Rotation2Dd(x[0]) * link;
    const Vector2d second = Eigen::Rotation2Dd(x[0] + x[1]) * tip;
    Eigen::Matrix2d H = none;
    H << -first[1] - second[1], -second[1], -second[1], -second[1];
    return Jet{first[1] + second[1], Vector2d(first[0] + second[0], second[0]), H};
  };
  std::mt19937 random(3);
  expect_whole(RoundGap::Moves::kHinges, wall, 0.5, random);
}

TEST(RoundGap, DegenerateIsUnknown) {
  const auto moves = [](RoundGap::Moves as, const Vector2d& g, const Eigen::Matrix2d& H) {
    return told(as, {0.0, g, H}).moves();
  };
  const auto symmetric = [](double a, double b, double c) {
    return (Eigen::Matrix2d() << a, b, b, c).finished();
  };
  const Vector2d g(0.04, 0.02);
  using Moves = RoundGap::Moves;
  // The normal leads through the second hinge; the heights over both are the same; no H at all.
  EXPECT_EQ(moves(Moves::kHinges, g, symmetric(0.02, 0.0, 0.0)), Moves::kUnknown);
  EXPECT_EQ(moves(Moves::kHinges, g, symmetric(0.02, 0.02, 0.02)), Moves::kUnknown);
  EXPECT_EQ(moves(Moves::kHinges, g, symmetric(0.0, 0.0, 0.0)), Moves::kUnknown);
  // A distance does not turn its gradient along itself.
  EXPECT_EQ(moves(Moves::kPoint, {1.0, 0.0}, symmetric(1.0, 0.0, 30.0)), Moves::kUnknown);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(moves(Moves::kPoint, {1.0, 0.0}, symmetric(nan, 0.0, 30.0)), Moves::kUnknown);
  EXPECT_EQ(moves(Moves::kHinges, g, symmetric(nan, 0.01, 0.02)), Moves::kUnknown);
}

TEST(RoundGap, TwoCurvaturesAreUnknown) {
  Jet saddle{0.0, Vector3d(0.0, 0.0, 1.0), Vector3d(30.0, 20.0, 0.0).asDiagonal()};
  EXPECT_EQ(told(RoundGap::Moves::kPoint, saddle).moves(), RoundGap::Moves::kUnknown);
  saddle.H(1, 1) = 30.0;
  EXPECT_EQ(told(RoundGap::Moves::kPoint, saddle).moves(), RoundGap::Moves::kPoint);
}

}  // namespace
}  // namespace haptic::core::round_gap_test
