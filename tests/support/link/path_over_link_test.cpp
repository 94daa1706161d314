/// The shipped wire code - channel, path machine, statistics, clock offset - at both ends of the
/// impaired link, on virtual time, through every scenario.

#include <gtest/gtest.h>

#include <memory>

#include "haptic/wire/clock_offset.hpp"
#include "haptic/wire/path_machine.hpp"
#include "haptic/wire/secure_channel.hpp"
#include "tests/support/link/impaired_link.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

constexpr LinkTime kMillisecond{1'000'000};

wire::TimePoint point(LinkTime time) {
  return wire::TimePoint(1000s + time);
}

/// One end: sends a datagram of data every `period` while its path is in use.
struct LinkEnd {
  LinkEnd(wire::End which, const wire::PathKeys& keys, std::uint64_t seed, ImpairedLink& out)
      : is_client(which == wire::End::kClient),
        channel(which, keys),
        machine({}, [random = Random(seed)]() mutable { return random.next(); }),
        link(out) {}

  void send(wire::DatagramType type, wire::ConstBytes payload, LinkTime now) {
    Packet packet(wire::kLargestDatagram);
    packet.resize(channel.seal(type, payload, packet));
    ASSERT_FALSE(packet.empty());
    link.send(std::move(packet), now);
  }

  void take(const Packet& packet, LinkTime now) {
    Packet payload(wire::kLargestPayload);
    const wire::Opened opened = channel.open(packet, payload, point(now));
    if (opened.rejection != wire::Rejection::kNone) return statistics.rejected(opened.rejection);
    statistics.accepted(opened.header.packet_number, packet.size(), point(now));
    payload.resize(opened.size);
    if (!is_client) machine.heard(other, point(now));
    if (opened.header.type == wire::DatagramType::kPathChallenge) {
      answer(payload, now);
    } else if (opened.header.type == wire::DatagramType::kPathResponse) {
      hear_answer(*wire::read_response(payload), now);
    } else {
      EXPECT_GE(opened.size, 8U);
      ++data;
      newest_data = std::max(newest_data, wire::get_u64(payload));
    }
  }

  void answer(Packet& payload, LinkTime now) {
    const auto challenge = wire::read_challenge(payload);
    ASSERT_TRUE(challenge);
    const auto reading = (clock(now)).count();
    wire::write(wire::PathResponse{challenge->token, reading, reading, statistics.packets(),
                                   statistics.newest()},
                payload);
    send(wire::DatagramType::kPathResponse, payload, now);
  }

  void hear_answer(const wire::PathResponse& response, LinkTime now) {
    if (const auto sent = machine.sent_at(response.token)) {
      offset.add({*sent, wire::Duration(response.received_ns), wire::Duration(response.sent_ns),
                  point(now)});
    }
    note(machine.responded(other, response, point(now)), now);
  }

  void step(LinkTime now) {
    note(machine.step(point(now)), now);
    while (const auto due = machine.due(point(now))) {
      Packet payload(due->size);
      wire::write(wire::PathChallenge{due->token}, payload);
      send(wire::DatagramType::kPathChallenge, payload, now);
    }
    if (!machine.in_use() || now < next_data) return;
    next_data = now + 2 * kMillisecond;
    Packet payload(60);
    wire::put(++data_sent, payload);
    send(is_client ? wire::DatagramType::kProxy : wire::DatagramType::kState, payload, now);
    in_use_at = now;
  }

  void note(wire::PathChange change, LinkTime now) {
    if (change != wire::PathChange::kNone) changes.emplace_back(now, change);
  }

  bool is_client;
  wire::SecureChannel channel;
  wire::PathMachine machine;
  ImpairedLink& link;
  wire::LinkStatistics statistics{};
  wire::ClockOffset offset{};
  std::function<LinkTime(LinkTime)> clock{[](LinkTime now) { return now; }};
  wire::PeerAddress other{};
  std::vector<std::pair<LinkTime, wire::PathChange>> changes{};
  LinkTime next_data{0}, in_use_at{-1};
  std::uint64_t data_sent{0}, data{0}, newest_data{0};
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
    client->machine.start(client->other, point(LinkTime(0)));
    for (LinkTime now{0}; now < scenario.duration; now += kMillisecond) {
      while (auto packet = up.receive(now)) server->take(packet->second, now);
      while (auto packet = down.receive(now)) client->take(packet->second, now);
      client->step(now);
      server->step(now);
    }
  }

  ImpairedLink up, down;
  std::unique_ptr<LinkEnd> client, server;
};

Scenario shipped(const std::string& name) {
  return read_scenario(HAPTIC_SOURCE_DIR "/tests/relay/scenarios/" + name + ".textproto");
}

bool has(const LinkEnd& end, wire::PathChange change, LinkTime from, LinkTime to) {
  return std::any_of(end.changes.begin(), end.changes.end(), [&](const auto& c) {
    return c.second == change && c.first >= from && c.first < to;
  });
}

class PathOverLink : public testing::TestWithParam<Scenario> {};

TEST_P(PathOverLink, NothingPassesTwiceAndTheCountsAddUp) {
  Trip run(GetParam());
  for (const LinkEnd* end : {run.client.get(), run.server.get()}) {
    const LinkEnd& sender = end->is_client ? *run.server : *run.client;
    EXPECT_LE(end->data, sender.data_sent);
    EXPECT_LE(end->newest_data, sender.data_sent);
    EXPECT_EQ(end->statistics.counters().rejections(wire::Rejection::kTag), 0U);
    // Every number up to the newest came, or is lost.
    EXPECT_EQ(end->statistics.packets() + end->statistics.counters().lost,
              end->statistics.newest());
    if (GetParam().up.duplicate == 1.0) {
      EXPECT_GT(end->statistics.counters().duplicate(), 100U);
    } else {
      EXPECT_EQ(end->statistics.counters().duplicate(), 0U);
    }
  }
}

TEST_P(PathOverLink, TheClocksTruthLiesWithinItsBoundWhileNothingStepped) {
  const Scenario& scenario = GetParam();
  if (!scenario.client_clock.steps.empty()) return;
  Trip run(scenario);
  const LinkTime end = scenario.duration - kMillisecond;
  const auto estimate = run.server->offset.at(point(end));
  if (!estimate) return;  // no answer ever came through
  const auto truth = client_clock(scenario.client_clock, end) - point(end).time_since_epoch();
  EXPECT_LE(std::chrono::abs(estimate->offset - truth), estimate->bound);
}

INSTANTIATE_TEST_SUITE_P(Shipped, PathOverLink, testing::ValuesIn(shipped_scenarios()),
                         [](const auto& test) { return test.param.name; });

TEST(PathOverScenario, UdpIsInUseWithinAFractionOfASecondOnAnyHealthyLink) {
  for (const char* name : {"clean", "delay_1ms", "delay_10ms", "delay_30ms", "delay_100ms",
                           "jitter_5ms", "jitter_20ms", "reorder_25", "duplicate_100", "loss_01"}) {
    Trip run(shipped(name));
    EXPECT_TRUE(run.client->machine.in_use()) << name;
    EXPECT_TRUE(run.server->machine.in_use()) << name;
    EXPECT_TRUE(has(*run.client, wire::PathChange::kUp, 0ms, 600ms)) << name;
  }
}

TEST(PathOverScenario, StaysOnUdpUpTo10PercentLoss) {
  for (const char* name : {"loss_01", "loss_05", "loss_10", "burst_8ms", "burst_50ms"}) {
    Trip run(shipped(name));
    for (const LinkEnd* end : {run.client.get(), run.server.get()}) {
      EXPECT_TRUE(end->machine.in_use()) << name;
      EXPECT_FALSE(has(*end, wire::PathChange::kLossy, 0s, 1h)) << name;
      EXPECT_FALSE(has(*end, wire::PathChange::kSilent, 0s, 1h)) << name;
    }
  }
}

TEST(PathOverScenario, BlockedUdpFallsBackWithin150MsAndReturns) {
  Trip run(shipped("udp_blocked"));
  for (const LinkEnd* end : {run.client.get(), run.server.get()}) {
    EXPECT_TRUE(has(*end, wire::PathChange::kSilent, 2s + 80ms, 2s + 150ms));
    EXPECT_TRUE(has(*end, wire::PathChange::kUp, 5s, 12s));
    EXPECT_TRUE(end->machine.in_use());
  }
}

TEST(PathOverScenario, OneWayIsAsGoodAsNone) {
  for (const char* name : {"partition_1s_up", "partition_1s_down"}) {
    Trip run(shipped(name));
    for (const LinkEnd* end : {run.client.get(), run.server.get()}) {
      EXPECT_TRUE(has(*end, wire::PathChange::kSilent, 2s, 2s + 200ms)) << name;
      EXPECT_TRUE(end->machine.in_use()) << name;  // and back at the end
    }
  }
}

TEST(PathOverScenario, BlockedTcpDoesNotConcernIt) {
  Trip run(shipped("tcp_blocked"));
  EXPECT_EQ(run.client->changes.size(), 1U);
  EXPECT_EQ(run.server->changes.size(), 1U);
}

TEST(PathOverScenario, AStepOfTheClientsClockIsFollowed) {
  for (const auto& [name, by] : {std::pair("clock_step_forward", 1s), {"clock_step_back", -1s}}) {
    Trip run(shipped(name));
    EXPECT_EQ(run.server->offset.steps(), 1U) << name;
    const auto estimate = run.server->offset.at(point(8s));
    ASSERT_TRUE(estimate);
    EXPECT_LE(std::chrono::abs(estimate->offset + 1000s - by), estimate->bound) << name;
  }
}

TEST(PathOverScenario, ADriftOf200PpmIsFound) {
  Trip run(shipped("clock_drift"));
  EXPECT_NEAR(run.server->offset.at(point(20s))->drift, 200e-6, 60e-6);
}

}  // namespace
}  // namespace haptic::test
