/// The proxy of contacts, against what a minimum is, and what is refused. Single contacts are in
/// the shared vectors (contact_vectors_test.cpp).

#include "haptic/client/solve.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/client/rules/expect_near.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::client {
namespace {

using Vector = std::vector<double>;
constexpr double kRigid = std::numeric_limits<double>::infinity();
constexpr double kRadius = 0.03;

/// A ball around the origin that the point (x, y, z) meets.
ContactsAt ball(double stiffness, double radius = kRadius) {
  return [=](const Vector& x) {
    Contact c{.point = point_itself(x), .stiffness = stiffness, .id = 1};
    const double from = std::hypot(x[0], x[1], x[2]);
    for (std::size_t i = 0; i < 3; ++i) c.normal[i] = x[i] / from;
    c.gap = from - radius;
    c.curvature = sphere_curvature(c.normal, from);
    return std::vector<Contact>{c};
  };
}

TEST(Solve, WithoutContactsTheProxyIsFree) {
  const Vector probe{0.02, -0.03, 0.1};
  const Solution free = solve([](const Vector&) { return std::vector<Contact>{}; }, probe, 1.0);
  EXPECT_TRUE(free.converged);
  EXPECT_EQ(free.x, probe);
  EXPECT_EQ(free.proxy().mode, Mode::kFree);
}

/// Flat contacts of random coordinates: the energy is convex, so the x at which its differences are
/// 0 is the answer.
TEST(Solve, RandomContactsLeaveNoSlope) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int run = 0; run < 200; ++run) {
    const std::size_t n = 1 + static_cast<std::size_t>(run % 7);
    std::vector<Contact> told(static_cast<std::size_t>(run % 30));
    Vector probe, weights;
    for (std::size_t i = 0; i < n; ++i) {
      probe.push_back(normal(random));
      weights.push_back(std::exp(normal(random)));
    }
    for (Contact& c : told) {
      c.normal = {1.0, 0.0, 0.0};
      c.gap = normal(random);
      c.stiffness = std::exp(4.0 * normal(random));
      for (std::size_t i = 0; i < n; ++i) c.point.jacobian.push_back({normal(random), 0.0, 0.0});
    }
    const auto at = [&](const Vector& x) {
      std::vector<Contact> here = told;
      for (Contact& c : here) {
        for (std::size_t i = 0; i < n; ++i) c.gap += c.point.jacobian[i][0] * x[i];
      }
      return here;
    };
    const Solution found = solve(at, probe, 2.0, {.weights = weights});
    EXPECT_TRUE(found.converged) << run;
    double scale = 1.0;
    Vector slope;
    for (std::size_t i = 0; i < n; ++i) slope.push_back(2.0 * weights[i] * (found.x[i] - probe[i]));
    for (const Contact& c : at(found.x)) {
      scale = std::max(scale, c.stiffness);
      for (std::size_t i = 0; i < n; ++i) {
        slope[i] += c.stiffness * std::min(c.gap, 0.0) * c.point.jacobian[i][0];
      }
    }
    expect_near(slope, Vector(n, 0.0), 1e-11 * scale);
  }
}

/// A sheet of 20 mm, whose nearer surface counts.
TEST(Solve, TheStartDecidesTheSide) {
  const auto sheet = [](const Vector& x) {
    Contact c{.point = point_itself(x)};
    c.normal[2] = x[2] < 0.0 ? -1.0 : 1.0;
    c.gap = std::abs(x[2]) - 0.01;
    return std::vector<Contact>{c};
  };
  const Vector through{0.1, 0.0, -0.05}, inside{0.1, 0.0, -0.002};
  for (const Vector& probe : {through, inside}) {
    expect_near(solve(sheet, probe, 1.0, {.start = {0.0, 0.0, 0.02}}).x, {0.1, 0.0, 0.01}, 1e-11);
  }
  expect_near(solve(sheet, through, 1.0).x, through, 0.0);
  expect_near(solve(sheet, inside, 1.0).x, {0.1, 0.0, -0.01}, 1e-11);
}

/// x <= 0 and x >= 1, rigid.
TEST(Solve, ContradictionsDoNotConverge) {
  const auto at = [](const Vector& x) {
    Contact left{.point = {0, {}, {{1.0, 0.0, 0.0}}, {}}, .normal = {-1.0, 0.0, 0.0}, .gap = -x[0]};
    Contact right = left;
    right.normal[0] = 1.0;
    right.gap = x[0] - 1.0;
    return std::vector<Contact>{left, right};
  };
  const Solution found = solve(at, {5.0}, 1.0);
  EXPECT_FALSE(found.converged);
  EXPECT_NEAR(found.x[0], 0.5, 1e-6) << "the least violation";
}

TEST(Solve, StopsAfterItsIterations) {
  int calls = 0;
  const auto counted = [&calls](const Vector& x) {
    ++calls;
    return ball(kRigid)(x);
  };
  const Solution found =
      solve(counted, {0.003, 0.001, 0.0}, 1.0, {.start = {0.0, 0.03, 0.0}, .iterations = 2});
  EXPECT_FALSE(found.converged);
  EXPECT_EQ(found.iterations, 2);
  EXPECT_LE(calls, 1 + 2 * 31);
  EXPECT_TRUE(solve(counted, {0.003, 0.001, 0.0}, 1.0, {.start = found.x}).converged);
}

TEST(Solve, NamesWhatIsNotAllowed) {
  const double nan = std::nan("");
  const auto refusal = [](const ContactsAt& at, const Vector& probe, double coupling,
                          const SolveOptions& options = {}) {
    return test::message_of<std::invalid_argument>(
        [&] { return solve(at, probe, coupling, options); });
  };
  const Vector probe{0.01, 0.0, 0.0};
  EXPECT_EQ(refusal(ball(1.0), {0.0, nan, 0.0}, 1.0), "x_probe[1]: nan, must be finite");
  EXPECT_EQ(refusal(ball(1.0), probe, 0.0), "coupling: 0.000000, must be finite, > 0");
  EXPECT_EQ(refusal(ball(1.0), probe, 1.0, {.start = {1.0}}),
            "options.start: has 1 values, must have 3");
  EXPECT_EQ(refusal(ball(1.0), probe, 1.0, {.weights = {1.0, 1.0, 0.0}}),
            "options.weights[2]: 0.000000, must be > 0");
  EXPECT_EQ(refusal(ball(nan), probe, 1.0), "contacts[0].stiffness: nan, must be > 0");
  EXPECT_EQ(refusal(ball(1.0, nan), probe, 1.0), "contacts[0].gap: nan, must be finite");
  EXPECT_EQ(refusal(ball(1.0), {0.0, 0.0, 0.0}, 1.0),
            "contacts[0].normal . point.jacobian[0]: nan, must be finite")
      << "the centre of a ball has no normal";
}

}  // namespace
}  // namespace haptic::client
