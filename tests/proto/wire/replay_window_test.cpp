#include "haptic/wire/replay_window.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace haptic::wire {
namespace {

TEST(ReplayWindow, WorksUpToTheLastNumber) {
  constexpr std::uint64_t kLast = ~std::uint64_t{0};
  ReplayWindow window;
  window.commit(kLast - 1);
  EXPECT_EQ(window.check(kLast), Rejection::kNone);
  window.commit(kLast);
  EXPECT_EQ(window.check(kLast), Rejection::kDuplicate);
  EXPECT_EQ(window.check(kLast - 1), Rejection::kDuplicate);
  EXPECT_EQ(window.check(kLast - 2), Rejection::kNone);
  EXPECT_EQ(window.check(1), Rejection::kTooOld);  // numbers do not wrap
}

/// The definition itself, with a set of all that came, over random walks with leaps.
TEST(ReplayWindow, AgreesWithASetOfArrivals) {
  std::mt19937_64 random(11);
  for (int run = 0; run < 20; ++run) {
    ReplayWindow window;
    std::set<std::uint64_t> came;
    std::uint64_t newest = 0;
    for (int i = 0; i < 20'000; ++i) {
      const bool leap = random() % 500 == 0;
      const std::uint64_t ahead = random() % (leap ? 3000 : 40);
      const std::uint64_t behind = random() % (random() % 50 == 0 ? 1200 : 60);
      const std::uint64_t n = newest + ahead > behind ? newest + ahead - behind : 0;
      const bool too_old = n == 0 || n + 1024 <= newest;
      const Rejection expected = too_old              ? Rejection::kTooOld
                                 : came.count(n) != 0 ? Rejection::kDuplicate
                                                      : Rejection::kNone;
      ASSERT_EQ(window.check(n), expected) << "run " << run << " step " << i << " number " << n;
      if (expected != Rejection::kNone || random() % 4 == 0) continue;  // some are never genuine
      window.commit(n);
      came.insert(n);
      newest = std::max(newest, n);
    }
  }
}

}  // namespace
}  // namespace haptic::wire
