#include "tests/support/link/impaired_link.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kSeed = 42;

struct Arrival {
  std::size_t number{0};
  LinkTime sent{0}, arrived{0};
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

std::size_t overtaken(const std::vector<Arrival>& arrivals) {
  std::size_t count = 0, newest = 0;
  for (const Arrival& a : arrivals) {
    count += a.number < newest ? 1 : 0;
    newest = std::max(newest, a.number);
  }
  return count;
}

/// Shares of 20 000 packets, to five standard errors.
TEST(ImpairedLink, LosesReordersDuplicatesItsShares) {
  const auto count = [](double WayRules::*rule, double share) {
    WayRules rules;
    rules.*rule = share;
    rules.reorder_by = 15ms;
    return stream(ImpairedLink(rules, kSeed, Carrier::kUdp), 20'000);
  };
  EXPECT_NEAR(static_cast<double>(count(&WayRules::loss, 0.3).size()), 14'000.0, 325.0);
  EXPECT_EQ(count(&WayRules::duplicate, 1.0).size(), 40'000U);
  const auto reordered = count(&WayRules::reorder, 0.25);
  const auto late = std::count_if(reordered.begin(), reordered.end(),
                                  [](const Arrival& a) { return a.arrived - a.sent == 15ms; });
  EXPECT_NEAR(static_cast<double>(late), 5'000.0, 310.0);
  EXPECT_EQ(reordered.size(), 20'000U);
}

TEST(ImpairedLink, StallsDeliverBacklogInOrder) {
  WayRules rules{.delay = 10ms, .stalls = {{100ms, 400ms, Carrier::kAll}}};
  const auto arrivals = stream(ImpairedLink(rules, kSeed, Carrier::kUdp), 600);
  ASSERT_EQ(arrivals.size(), 600U);
  EXPECT_EQ(overtaken(arrivals), 0U);
  const auto at_once = std::count_if(arrivals.begin(), arrivals.end(),
                                     [](const Arrival& a) { return a.arrived == 400ms; });
  EXPECT_EQ(at_once, 301);  // sent from 90 ms to 389 ms, and the one due then
}

TEST(ReliableLink, KeepsAllInOrder) {
  WayRules rules{.loss = 0.02};
  const auto lossy = stream(ReliableLink(rules, kSeed), 5000);
  EXPECT_EQ(lossy.size(), 5000U);
  EXPECT_EQ(overtaken(lossy), 0U);
  rules = {};
  rules.partitions = {{100ms, 1100ms, Carrier::kTcp}};
  const auto arrivals = stream(ReliableLink(rules, kSeed), 300);
  ASSERT_EQ(arrivals.size(), 300U);
  // 200, 400, 800 ms after 100 ms: the third retransmission arrives.
  EXPECT_EQ(arrivals[100].arrived, 1500ms);
}

}  // namespace
}  // namespace haptic::test
