#include "server/base/bell.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace {

using namespace std::chrono_literals;
using haptic::core::TimePoint;
using haptic::server::Bell;
using Clock = std::chrono::steady_clock;

TimePoint in(haptic::core::Duration wait) {
  return TimePoint(Clock::now().time_since_epoch() + wait);
}

TEST(Bell, EarlyRingIsNotSleptThrough) {
  Bell bell;
  const std::uint32_t heard = bell.rings();
  bell.ring();
  bell.sleep(heard);  // a hang is ended by the test's own time limit
  bell.meet(heard, in(1h), 1h);
  EXPECT_EQ(bell.rings(), heard + 1);
}

TEST(Bell, MeetingEndsWhenPatienceDoes) {
  Bell bell;
  const Clock::time_point begin = Clock::now();
  bell.meet(bell.rings(), in(2ms), 1ms);
  EXPECT_GE(Clock::now() - begin, 3ms);
  EXPECT_EQ(bell.rings(), 0U);
}

TEST(Bell, MeetingHearsEarlyAndLateRings) {
  for (const bool early : {true, false}) {
    Bell bell;
    std::atomic<bool> met{false};
    std::thread waiting([&] {
      bell.meet(0, early ? in(1h) : in(0ns), 1h);
      met = true;
    });
    std::this_thread::sleep_for(1ms);
    EXPECT_FALSE(met);
    bell.ring();
    waiting.join();
    EXPECT_EQ(bell.rings(), 1U);
  }
}

TEST(Bell, PastExpectedTimeCausesNoSleep) {
  Bell bell;
  bell.meet(bell.rings(), TimePoint{}, 0ns);
  EXPECT_EQ(bell.rings(), 0U);
}

}  // namespace
