#include "hw/board/clock_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "hw/random.hpp"

namespace haptic::hw::board {
namespace {

using namespace std::chrono_literals;

/// A board with a crystal of its own behind a link with delays; true times are known here.
class Link {
 public:
  explicit Link(double ppm) : ppm_(ppm) {}
  /// Error of the mapped time of the next sample, s: mapped - true. `delay` s on the way.
  double next(double delay) {
    const double t = 1e-3 * ++count_;
    const auto board_us = static_cast<std::uint64_t>(std::llround(1e6 * t));
    const double truth = t * (1.0 + 1e-6 * ppm_);
    const core::TimePoint arrival = at(truth + delay);
    const core::TimePoint mapped = map.map(board_us, arrival);
    EXPECT_LE(mapped, arrival);
    return core::seconds(mapped - at(truth));
  }
  ClockMap map{};

 private:
  static core::TimePoint at(double s) {
    return core::TimePoint(1000s + core::Duration(std::llround(1e9 * s)));
  }
  double ppm_;
  int count_{0};
};

TEST(ClockMap, AConstantDelayStays) {
  Link link(150.0);
  for (int i = 0; i < 20000; ++i) {
    const double error = link.next(0.8e-3);
    if (i <= 5000) continue;
    ASSERT_NEAR(error, 0.8e-3, 5e-6) << i;
  }
}

TEST(ClockMap, LinkJitterIsRemoved) {
  Link link(-100.0);
  std::mt19937_64 random(3);
  double worst = 0.0, mean = 0.0;
  int count = 0;
  for (int i = 0; i < 20000; ++i) {
    const double error = link.next(1e-3 * uniform(random));  // 0..1 ms
    if (i < 5000) continue;
    worst = std::max(worst, std::abs(error));
    mean += error;
    ++count;
  }
  // Arrivals scatter over 1 ms (0.29 ms rms); the mapped times stay within a fifth of that.
  EXPECT_LT(worst, 0.2e-3);
  EXPECT_LT(std::abs(mean / count), 0.1e-3);
}

TEST(ClockMap, StragglersDoNotMoveTheLine) {
  Link link(0.0);
  for (int i = 0; i < 3000; ++i) static_cast<void>(link.next(0.2e-3));
  for (int i = 0; i < 3000; ++i) {
    const double error = link.next(i % 10 == 0 ? 8e-3 : 0.2e-3);
    ASSERT_NEAR(error, 0.2e-3, 20e-6) << i;
  }
}

TEST(ClockMap, ALastingDelayIsLearnt) {
  Link link(0.0);
  for (int i = 0; i < 3000; ++i) static_cast<void>(link.next(0.2e-3));
  double error = 0.0;
  for (int i = 0; i < 15000; ++i) error = link.next(3e-3);
  EXPECT_NEAR(error, 3e-3, 0.1e-3);
}

TEST(ClockMap, ARestartedBoardIsFollowed) {
  ClockMap map;
  const core::TimePoint t0(1000s);
  for (int i = 0; i < 1000; ++i) {
    static_cast<void>(map.map(5000000U + 1000U * static_cast<unsigned>(i), t0 + i * 1ms));
  }
  EXPECT_EQ(map.map(10, t0 + 1s), t0 + 1s);                   // its clock went back
  EXPECT_EQ(map.map(9000000, t0 + 1s + 1ms), t0 + 1s + 1ms);  // it jumped by 9 s
}

TEST(ClockMap, TimesRiseUnderJitter) {
  ClockMap map;
  std::mt19937_64 random(9);
  core::TimePoint arrival(1000s), last{};
  for (int i = 0; i < 20000; ++i) {
    arrival = std::max(
        arrival, core::TimePoint(1000s + i * 1ms +
                                 core::Duration(static_cast<std::int64_t>(2e6 * uniform(random)))));
    const core::TimePoint mapped = map.map(1000U * static_cast<unsigned>(i), arrival);
    ASSERT_GT(mapped, last) << i;
    last = mapped;
  }
}

}  // namespace
}  // namespace haptic::hw::board
