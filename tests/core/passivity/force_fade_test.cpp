// core/METHOD.md#forces-that-come-and-go
#include "haptic/core/passivity/force_fade.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

constexpr double kFadeTick = 1e-3, kFadeLimit = 25.0, kFadeMost = 0.125;  // s; N; N per tick

double step(EasedForce& force, double wish, double allowed) {
  return force.step(one(wish), one(allowed), one(kFadeLimit), kFadeTick)[0];
}

TEST(EasedForce, GoesAndComesSlowly) {
  EasedForce force(1);
  force.follow(one(5.0));
  double last = 5.0;
  int ticks = 0;
  for (; last != 0.0 && ticks < 200; ++ticks) {
    const double now = step(force, 5.0, 0.0);
    ASSERT_LE(now, last);
    ASSERT_GE(now, last - kFadeMost - 1e-12);
    last = now;
  }
  EXPECT_GT(ticks, 40);
  EXPECT_LT(ticks, 140) << "half of 5 N takes 20 ms, the end of it some more";
  for (ticks = 0; !force.whole() && ticks < 200; ++ticks) {
    const double now = step(force, 5.0, 5.0);
    ASSERT_LE(now, last + kFadeMost + 1e-12);
    last = now;
  }
  EXPECT_EQ(last, 5.0);
}

TEST(EasedForce, FollowsTheWishItself) {
  EasedForce force(1);
  EXPECT_EQ(step(force, 5.0, 0.0), 0.0) << "a push into a contact never begins";
  EXPECT_EQ(step(force, 5.0, 3.0), kFadeMost);
  force.follow(one(5.0));
  EXPECT_EQ(step(force, 2.0, 0.0), 2.0) << "its fall is not added to the wish's";
  EXPECT_FALSE(force.whole()) << "the next tick holds back";
  EXPECT_NEAR(step(force, 2.0, 0.0), 2.0 - 0.1, 1e-12) << "2 N / 20 ms";
  force.follow(one(5.0));
  EXPECT_EQ(step(force, 4.95, 0.0), 5.0 - kFadeMost) << "nor the wish's to its own";
  EXPECT_EQ(step(force, 0.0, 0.0), 0.0) << "the contact is left";
  force.follow(one(2.0));
  EXPECT_LT(step(force, 9.0, 0.0), 2.0) << "what is not allowed does not grow";
  force.restart();
  EXPECT_TRUE(force.whole());
  force.step(one(std::nan("")), one(0.0), one(kFadeLimit), kFadeTick);
  EXPECT_EQ(step(force, 1.0, 1.0), 1.0) << "a number again";
}

/// Whatever is wished and allowed: from rest nothing is given that is not allowed; later what is
/// left of a force that was allowed, which does not grow.
TEST(EasedForce, NeverBeginsAPush) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int n = 0; n < 200000; ++n) {
    EasedForce fresh(1);
    const double wish = 10.0 * normal(random), allowed = unit(random) < 0.5 ? 0.0 : unit(random);
    const double used = step(fresh, wish, allowed * wish) / wish;
    ASSERT_LE(used, allowed + 1e-12);
    ASSERT_GE(used, 0.0);
  }
  EasedForce force(1);
  double wish = 0.0, allowed = 1.0, used = 0.0;
  for (int n = 0; n < 200000; ++n) {
    wish += 0.05 * normal(random) - 0.001 * wish;
    if (unit(random) < 0.01) wish = 5.0 * normal(random);
    if (unit(random) < 0.02) allowed = unit(random) < 0.5 ? 0.0 : unit(random);
    const double before = used;
    used = step(force, wish, allowed * wish);
    const double most =
        wish > 0.0 ? std::max(allowed * wish, before) : -std::min(allowed * wish, before);
    ASSERT_LE(std::abs(used), std::max(most, 0.0) + 1e-12) << n;
    ASSERT_GE(used * wish, 0.0) << n;
  }
}

/// A contact that a noisy sensor tells half of the time: the force rests between, and its steps are
/// a twentieth of what they would be.
TEST(EasedForce, AveragesNoise) {
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  EasedForce force(1);
  force.follow(one(0.5));
  double last = 0.5, largest = 0.0;
  for (int n = 0; n < 5000; ++n) {
    const double now = step(force, 0.5, normal(random) > 0.0 ? 0.5 : 0.0);
    if (n > 0) largest = std::max(largest, std::abs(now - last));
    last = now;
  }
  EXPECT_LT(largest, 0.5 / 19.0);
}

}  // namespace
}  // namespace haptic::core
