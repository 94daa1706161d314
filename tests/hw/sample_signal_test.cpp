#include "hw/sample_signal.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "tests/support/allocation_guard.hpp"

namespace {

using namespace std::chrono_literals;
using haptic::core::Duration;
using haptic::core::TimePoint;
using haptic::hw::SampleSignal;

constexpr TimePoint kPast{Duration(1s)};

TEST(SampleSignal, APostIsTakenOnce) {
  SampleSignal signal;
  signal.post(kPast + 5ms);
  EXPECT_EQ(signal.wait_until(kPast), kPast + 5ms) << "a post counts even where the time is up";
  EXPECT_FALSE(signal.wait_until(kPast));
}

TEST(SampleSignal, ManyPostsAreOneSignal) {
  SampleSignal signal;
  for (int i = 1; i <= 100'000; ++i) signal.post(kPast + i * 1us);
  EXPECT_EQ(signal.wait_until(kPast), kPast + 1us);
  EXPECT_FALSE(signal.wait_until(kPast));
}

TEST(SampleSignal, ForgottenSamplesWakeNoLoop) {
  SampleSignal signal;
  signal.forget();
  signal.post(kPast);
  signal.forget();
  EXPECT_FALSE(signal.wait_until(kPast));
  signal.post(kPast + 1ms);
  EXPECT_EQ(signal.wait_until(kPast), kPast + 1ms);
}

TEST(SampleSignal, NeitherSideAllocates) {
  SampleSignal signal;
  const haptic::test::AllocationGuard guard;
  signal.post(kPast);
  static_cast<void>(signal.wait_until(kPast));
  signal.forget();
  EXPECT_EQ(guard.allocations() + guard.releases(), 0U);
}

/// The promise of the exchange: a sample that was put down before its post is seen by the taker of
/// that post, or of the one it was merged with; none is waited for in vain.
TEST(SampleSignal, ThreadsMissNoSample) {
  constexpr int kRounds = 20'000;
  SampleSignal signal;
  std::atomic<int> newest{0}, seen{0};
  std::atomic<bool> given_up{false};
  std::thread device([&] {
    for (int round = 0; round < kRounds; ++round) {
      while (seen < 2 * round && !given_up) std::this_thread::yield();
      for (int sample :
           {2 * round + 1, 2 * round + 2}) {  // the second meets whoever takes the first
        newest.store(sample, std::memory_order_relaxed);
        signal.post(kPast + sample * 1ns);
      }
    }
  });
  const TimePoint patience{std::chrono::steady_clock::now().time_since_epoch() + 60s};
  while (seen < 2 * kRounds && !given_up) {
    const auto arrival = signal.wait_until(patience);
    given_up = !arrival;
    const int now = newest.load(std::memory_order_relaxed);
    EXPECT_GE(kPast + now * 1ns, arrival.value_or(kPast)) << "woken before the sample was there";
    seen = now;
  }
  EXPECT_FALSE(given_up) << "waited in vain after sample " << seen;
  device.join();
}

}  // namespace
