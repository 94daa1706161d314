/// The shipped wire code - channel, path machine, statistics, clock offset - at both ends of the
/// impaired link, on virtual time, through every scenario.

#include <gtest/gtest.h>

#include <memory>

#include "haptic/wire/path_end.hpp"
#include "tests/support/link/impaired_link.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

constexpr LinkTime kMillisecond{1'000'000};

wire::TimePoint point(LinkTime time) {
  return wire::TimePoint(1000s + time);
}

/// One end: sends a message every 2 ms while its path is in use.
struct LinkEnd {
  LinkEnd(wire::End which, const wire::PathKeys& keys, std::uint64_t seed, ImpairedLink& out)
      : end({which,
             keys,
             {},
             [this, &out](const wire::PeerAddress&, wire::ConstBytes datagram) {
               out.send({datagram.begin(), datagram.end()}, now);
             },
             [random = Random(seed)]() mutable { return random.next(); }}) {}
  LinkEnd(const LinkEnd&) = delete;
  LinkEnd& operator=(const LinkEnd&) = delete;

  /// `reading`: of this end's own clock.
  [[nodiscard]] wire::TimePoint reading() const { return wire::TimePoint(1000s + clock(now)); }

  void take(const Packet& packet) {
    const wire::Received received = end.receive(packet, other, reading());
    note(received.change);
    if (!received.message) return;
    ++messages;
    newest_message = std::max(newest_message, wire::get<std::uint64_t>(*received.message));
  }

  void step() {
    note(end.step(reading()));
    if (!end.in_use() || now < next_message) return;
    next_message = now + 2 * kMillisecond;
    Packet payload(60);
    wire::put(++messages_sent, payload);
    EXPECT_TRUE(end.send(payload));
  }

  void note(wire::PathChange change) {
    if (change != wire::PathChange::kNone) changes.emplace_back(now, change);
  }

  LinkTime now{0};
  std::function<LinkTime(LinkTime)> clock{[](LinkTime truth) { return truth; }};
  wire::PeerAddress other{};
  wire::PathEnd end;
  std::vector<std::pair<LinkTime, wire::PathChange>> changes{};
  LinkTime next_message{0};
  std::uint64_t messages_sent{0}, messages{0}, newest_message{0};
};

struct Trip {
  explicit Trip(const Scenario& scenario)
      : up(scenario.up, scenario.seed, Carrier::kUdp),
        down(scenario.down, scenario.seed + 1000, Carrier::kUdp) {
    const wire::PathKeys keys = wire::fresh_keys();
    client = std::make_unique<LinkEnd>(wire::End::kClient, keys, 1, up);
    server = std::make_unique<LinkEnd>(wire::End::kServer, keys, 2, down);
    client->other.port = 1;
    server->other.port = 2;
    client->clock = [rules = scenario.client_clock](LinkTime now) {
      return client_clock(rules, now);
    };
    client->end.start(client->other, client->reading());
    for (LinkTime now{0}; now < scenario.duration; now += kMillisecond) {
      client->now = server->now = now;
      while (auto packet = up.receive(now)) server->take(packet->second);
      while (auto packet = down.receive(now)) client->take(packet->second);
      client->step();
      server->step();
    }
  }

  ImpairedLink up, down;
  std::unique_ptr<LinkEnd> client, server;
};

bool has(const LinkEnd& end, wire::PathChange change, LinkTime from, LinkTime to) {
  return std::any_of(end.changes.begin(), end.changes.end(), [&](const auto& c) {
    return c.second == change && c.first >= from && c.first < to;
  });
}

class PathOverLink : public testing::TestWithParam<Scenario> {};

TEST_P(PathOverLink, NothingPassesTwiceAndCountsBalance) {
  Trip run(GetParam());
  for (LinkEnd* const end : {run.client.get(), run.server.get()}) {
    const LinkEnd& sender = end == run.client.get() ? *run.server : *run.client;
    EXPECT_LE(end->messages, sender.messages_sent);
    EXPECT_LE(end->newest_message, sender.messages_sent);
    EXPECT_EQ(end->end.counters().rejections(wire::Rejection::kTag), 0U);
    // Every number up to the newest came, or is lost.
    EXPECT_EQ(end->end.statistics().packets() + end->end.counters().lost,
              end->end.statistics().newest());
    if (GetParam().up.duplicate == 1.0) {
      EXPECT_GT(end->end.counters().duplicate(), 100U);
    } else {
      EXPECT_EQ(end->end.counters().duplicate(), 0U);
    }
  }
}

TEST_P(PathOverLink, SteadyClocksTruthLiesWithinBound) {
  const Scenario& scenario = GetParam();
  if (!scenario.client_clock.steps.empty()) return;
  Trip run(scenario);
  const LinkTime end = scenario.duration - kMillisecond;
  const auto estimate = run.server->end.clock_offset().at(point(end));
  if (!estimate) return;  // no answer ever came through
  const auto truth = client_clock(scenario.client_clock, end) - end;
  EXPECT_LE(std::chrono::abs(estimate->offset - truth), estimate->bound);
}

INSTANTIATE_TEST_SUITE_P(Shipped, PathOverLink, testing::ValuesIn(shipped_scenarios()),
                         [](const auto& test) { return test.param.name; });

TEST(PathOverScenario, HealthyLinkUsesUdpQuickly) {
  for (const char* name : {"clean", "delay_1ms", "delay_10ms", "delay_30ms", "delay_100ms",
                           "jitter_5ms", "jitter_20ms", "reorder_25", "duplicate_100", "loss_01"}) {
    Trip run(shipped_scenario(name));
    EXPECT_TRUE(run.client->end.in_use()) << name;
    EXPECT_TRUE(run.server->end.in_use()) << name;
    EXPECT_TRUE(has(*run.client, wire::PathChange::kUp, 0ms, 600ms)) << name;
  }
}

TEST(PathOverScenario, OneWayPathIsNotUsed) {
  for (const char* name : {"partition_1s_up", "partition_1s_down"}) {
    Trip run(shipped_scenario(name));
    for (const LinkEnd* end : {run.client.get(), run.server.get()}) {
      EXPECT_TRUE(has(*end, wire::PathChange::kSilent, 2s, 2s + 200ms)) << name;
      EXPECT_TRUE(end->end.in_use()) << name;  // and back at the end
    }
  }
}

TEST(PathOverScenario, BlockedTcpDoesNotConcernIt) {
  Trip run(shipped_scenario("tcp_blocked"));
  EXPECT_EQ(run.client->changes.size(), 1U);
  EXPECT_EQ(run.server->changes.size(), 1U);
}

TEST(PathOverScenario, FollowsAStepOfClientsClock) {
  for (const auto& [name, by] : {std::pair("clock_step_forward", 1s), {"clock_step_back", -1s}}) {
    Trip run(shipped_scenario(name));
    EXPECT_EQ(run.server->end.clock_offset().steps(), 1U) << name;
    const auto estimate = run.server->end.clock_offset().at(point(8s));
    ASSERT_TRUE(estimate);
    EXPECT_LE(std::chrono::abs(estimate->offset - by), estimate->bound) << name;
  }
}

TEST(PathOverScenario, FindsADriftOf200Ppm) {
  Trip run(shipped_scenario("clock_drift"));
  EXPECT_NEAR(run.server->end.clock_offset().at(point(20s))->drift, 200e-6, 60e-6);
}

}  // namespace
}  // namespace haptic::test
