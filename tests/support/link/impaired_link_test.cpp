#include "tests/support/link/impaired_link.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kSeed = 42;

struct Arrival {
  std::size_t number{0};
  LinkTime sent{0}, arrived{0};
  [[nodiscard]] LinkTime took() const { return arrived - sent; }
};

/// `count` packets, one a millisecond, through `link`; arrivals in order of time.
template <typename Link>
std::vector<Arrival> stream(Link link, std::size_t count, std::size_t size = 100) {
  std::vector<Arrival> arrivals;
  const auto take = [&](LinkTime now) {
    while (auto packet = link.receive(now)) {
      const std::size_t number =
          packet->second[0] + 256U * packet->second[1] + 65536U * packet->second[2];
      arrivals.push_back({number, static_cast<int>(number) * 1ms, packet->first});
    }
  };
  for (std::size_t i = 0; i < count; ++i) {
    const LinkTime now = static_cast<int>(i) * 1ms;
    Packet packet(size);
    packet[0] = static_cast<std::uint8_t>(i & 255U);
    packet[1] = static_cast<std::uint8_t>((i >> 8U) & 255U);
    packet[2] = static_cast<std::uint8_t>(i >> 16U);
    link.send(std::move(packet), now);
    take(now);
  }
  take(LinkTime::max());
  return arrivals;
}

std::vector<Arrival> through(const WayRules& rules, std::size_t count,
                             Carrier who = Carrier::kUdp) {
  return stream(ImpairedLink(rules, kSeed, who), count);
}

double mean_ms(const std::vector<Arrival>& arrivals) {
  double sum = 0.0;
  for (const Arrival& a : arrivals)
    sum += std::chrono::duration<double, std::milli>(a.took()).count();
  return sum / static_cast<double>(arrivals.size());
}

std::size_t overtaken(const std::vector<Arrival>& arrivals) {
  std::size_t count = 0, newest = 0;
  for (const Arrival& a : arrivals) {
    count += a.number < newest ? 1 : 0;
    newest = std::max(newest, a.number);
  }
  return count;
}

TEST(ImpairedLink, ACleanOneIsInstantAndComplete) {
  const auto arrivals = through(WayRules{}, 1000);
  ASSERT_EQ(arrivals.size(), 1000U);
  for (const Arrival& a : arrivals) EXPECT_EQ(a.took(), 0ns);
  EXPECT_EQ(overtaken(arrivals), 0U);
}

TEST(ImpairedLink, NothingArrivesBeforeItsTime) {
  WayRules rules;
  rules.delay = 10ms;
  ImpairedLink link(rules, kSeed, Carrier::kUdp);
  EXPECT_EQ(link.next_arrival(), LinkTime::max());
  link.send({1}, 5ms);
  EXPECT_EQ(link.next_arrival(), 15ms);
  EXPECT_FALSE(link.receive(15ms - 1ns));
  const auto packet = link.receive(15ms);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->first, 15ms);
  EXPECT_EQ(packet->second, Packet{1});
  EXPECT_FALSE(link.receive(1h));
}

TEST(ImpairedLink, SameSeedSameArrivalsAnotherSeedOthers) {
  WayRules rules;
  rules.delay = 10ms;
  rules.jitter_sigma = 5ms;
  rules.loss = 0.1;
  const auto times = [&](std::uint64_t seed) {
    std::vector<std::int64_t> answer;
    for (const Arrival& a : stream(ImpairedLink(rules, seed, Carrier::kUdp), 500)) {
      answer.push_back(a.arrived.count());
    }
    return answer;
  };
  EXPECT_EQ(times(1), times(1));
  EXPECT_NE(times(1), times(2));
}

TEST(ImpairedLink, JitterIsHalfANormalOnTopOfTheDelay) {
  WayRules rules;
  rules.delay = 10ms;
  rules.jitter_sigma = 5ms;
  const auto arrivals = through(rules, 20'000);
  for (const Arrival& a : arrivals) ASSERT_GE(a.took(), 10ms);
  // E|N(0,1)| = sqrt(2/pi); five standard errors of the mean of 20 000.
  EXPECT_NEAR(mean_ms(arrivals), 10.0 + 5.0 * std::sqrt(2.0 / std::numbers::pi), 0.11);
  EXPECT_GT(overtaken(arrivals), 1000U);
  rules.keep_order = true;
  EXPECT_EQ(overtaken(through(rules, 20'000)), 0U);
}

TEST(ImpairedLink, LosesItsShareEachOnItsOwn) {
  for (const double loss : {0.01, 0.05, 0.3}) {
    WayRules rules;
    rules.loss = loss;
    const auto arrivals = through(rules, 50'000);
    const double share = 1.0 - static_cast<double>(arrivals.size()) / 50'000.0;
    EXPECT_NEAR(share, loss, 5.0 * std::sqrt(loss * (1.0 - loss) / 50'000.0));
    // After a lost one the next is lost as often as any.
    std::size_t after_lost = 0, lost_again = 0;
    std::vector<bool> came(50'000, false);
    for (const Arrival& a : arrivals) came[a.number] = true;
    for (std::size_t i = 0; i + 1 < came.size(); ++i) {
      after_lost += came[i] ? 0 : 1;
      lost_again += !came[i] && !came[i + 1] ? 1 : 0;
    }
    const auto n = static_cast<double>(after_lost);
    EXPECT_NEAR(static_cast<double>(lost_again) / n, loss, 5.0 * std::sqrt(loss / n));
  }
}

TEST(ImpairedLink, BurstsAreTimesNotPackets) {
  const BurstRule rule{1000ms, 50ms};
  BurstSchedule forward(rule, 7), backward(rule, 7);
  std::vector<bool> there;
  for (int ms = 0; ms < 100'000; ++ms) there.push_back(forward.blocked(ms * 1ms));
  for (int ms = 99'999; ms >= 0; --ms) {
    ASSERT_EQ(backward.blocked(ms * 1ms), there[static_cast<std::size_t>(ms)]) << ms;
  }
  // 50 ms of every 1050 ms; a burst lasts 50 ms.
  const auto blocked = static_cast<double>(std::count(there.begin(), there.end(), true));
  EXPECT_NEAR(blocked / 100'000.0, 50.0 / 1050.0, 0.02);
  int length = 0;
  for (std::size_t i = 1; i < there.size(); ++i) {
    length = there[i] ? length + 1 : 0;
    if (length > 0 && i + 1 < there.size() && !there[i + 1]) {
      EXPECT_GE(length, 49);
    }
  }
}

TEST(ImpairedLink, APartitionHoldsFromItsBeginningToBeforeItsEnd) {
  WayRules rules;
  rules.delay = 10ms;
  rules.partitions = {{100ms, 200ms, Carrier::kAll}};
  const auto arrivals = through(rules, 300);
  EXPECT_EQ(arrivals.size(), 200U);
  for (const Arrival& a : arrivals) EXPECT_TRUE(a.sent < 100ms || a.sent >= 200ms);
}

TEST(ImpairedLink, AWindowOfOneCarrierLeavesTheOtherAlone) {
  WayRules rules;
  rules.partitions = {{100ms, 200ms, Carrier::kUdp}};
  EXPECT_EQ(through(rules, 300, Carrier::kUdp).size(), 200U);
  EXPECT_EQ(through(rules, 300, Carrier::kTcp).size(), 300U);
}

TEST(ImpairedLink, AStallDeliversItsBackLogAtOnceAndInOrder) {
  WayRules rules;
  rules.delay = 10ms;
  rules.stalls = {{100ms, 400ms, Carrier::kAll}};
  const auto arrivals = through(rules, 600);
  ASSERT_EQ(arrivals.size(), 600U);
  EXPECT_EQ(overtaken(arrivals), 0U);
  const auto at_once = std::count_if(arrivals.begin(), arrivals.end(),
                                     [](const Arrival& a) { return a.arrived == 400ms; });
  EXPECT_EQ(at_once, 301);  // sent from 90 ms to 389 ms, and the one due then anyway
}

TEST(ImpairedLink, ReordersAndDuplicatesTheirShares) {
  WayRules rules;
  rules.reorder = 0.25;
  rules.reorder_by = 15ms;
  const auto reordered = through(rules, 20'000);
  const auto late = std::count_if(reordered.begin(), reordered.end(),
                                  [](const Arrival& a) { return a.took() == 15ms; });
  EXPECT_NEAR(static_cast<double>(late) / 20'000.0, 0.25, 0.016);
  EXPECT_EQ(reordered.size(), 20'000U);
  WayRules twice;
  twice.duplicate = 1.0;
  EXPECT_EQ(through(twice, 1000).size(), 2000U);
}

TEST(ImpairedLink, ARateStretchesAndItsQueueDrops) {
  WayRules rules;
  rules.bytes_per_second = 50'000.0;  // half of what a packet of 100 bytes per ms needs
  rules.queue_bytes = 1000.0;
  const auto arrivals = through(rules, 1000);
  EXPECT_NEAR(static_cast<double>(arrivals.size()), 500.0, 12.0);
  for (const Arrival& a : arrivals) {
    EXPECT_GE(a.took(), 2ms);   // 100 bytes
    EXPECT_LE(a.took(), 20ms);  // a full queue
  }
}

TEST(ReliableLink, LosesNothingKeepsOrderAndLetsTheRestWait) {
  WayRules rules;
  rules.delay = 10ms;
  rules.loss = 0.02;
  const auto arrivals = stream(ReliableLink(rules, kSeed), 5000);
  ASSERT_EQ(arrivals.size(), 5000U);
  EXPECT_EQ(overtaken(arrivals), 0U);
  // What was lost takes a timeout more; what was not, and came behind it, waits as long as that.
  std::size_t waiting = 0;
  for (const Arrival& a : arrivals) {
    EXPECT_GE(a.took(), 10ms);
    waiting += a.took() > 10ms ? 1 : 0;
  }
  EXPECT_GT(waiting, 2500U);
}

TEST(ReliableLink, OutlastsAPartition) {
  WayRules rules;
  rules.partitions = {{100ms, 1100ms, Carrier::kTcp}};
  const auto arrivals = stream(ReliableLink(rules, kSeed), 300);
  ASSERT_EQ(arrivals.size(), 300U);
  EXPECT_EQ(arrivals.front().took(), 0ns);
  // 200, 400, 800 ms after 100 ms: the third try gets through.
  EXPECT_EQ(arrivals[100].arrived, 1500ms);
}

TEST(ClientClock, DriftsAndSteps) {
  ClockRules rules;
  rules.drift = 200e-6;
  rules.steps = {{3s, -1s}};
  EXPECT_EQ(client_clock(rules, 2s), 2s + 400us);
  EXPECT_EQ(client_clock(rules, 3s), 2s + 600us);
  EXPECT_EQ(client_clock({}, 5s), 5s);
}

}  // namespace
}  // namespace haptic::test
