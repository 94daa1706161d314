/// Every scenario of WIRE 6 on virtual time, through the shipped wire, ingress, sessions and
/// pipeline: a client of 100 Hz that presses, over UDP where its path is in use, else over a
/// stream.

#include <gtest/gtest.h>

#include <bit>
#include <memory>

#include "haptic/wire/path_end.hpp"
#include "tests/server/support/device_rig.hpp"
#include "tests/support/link/impaired_link.hpp"

namespace haptic::test {
namespace {

constexpr LinkTime kSamplePeriod = 10ms;
constexpr core::TimePoint kStart{1h};
constexpr double kSlewPerTick = 1000.0 * 1e-3;  // rig_config(), N

wire::TimePoint to_wire(core::TimePoint time) {
  return wire::TimePoint(time.time_since_epoch());
}

/// A sample as these tests put it into a datagram; what protobuf does is tested elsewhere.
Packet packed(std::uint64_t seq, double a) {
  Packet packet(16);
  wire::put(seq, packet);
  wire::put(std::bit_cast<std::uint64_t>(a), wire::Bytes(packet).subspan(8));
  return packet;
}

struct World {
  explicit World(const Scenario& which)
      : scenario(which),
        udp_up(which.up, which.seed, haptic::test::Carrier::kUdp),
        udp_down(which.down, which.seed + 1000, haptic::test::Carrier::kUdp),
        stream_up(which.up, which.seed + 2000),
        client({wire::End::kClient, keys, rules(),
                [this](const wire::PeerAddress&, wire::ConstBytes datagram) {
                  udp_up.send({datagram.begin(), datagram.end()}, time());
                },
                [random = Random(1)]() mutable { return random.next(); }}),
        server({wire::End::kServer, keys, rules(),
                [this](const wire::PeerAddress&, wire::ConstBytes datagram) {
                  udp_down.send({datagram.begin(), datagram.end()}, time());
                },
                [random = Random(2)]() mutable { return random.next(); }}) {
    server::LeaseRequest request;
    request.session_id = "s1";
    request.client_name = "alice";
    request.nominal_rate_hz = 100.0;
    rig.tick(3);
    rig.sessions->open_controller(request, rig.now,
                                  [this](const server::Outcome<server::Lease>& outcome) {
                                    ASSERT_TRUE(outcome);
                                    lease = *outcome.value;
                                  });
    rig.tick(10);
    began = rig.now;
    client.start(client_sees, to_wire(rig.now));
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  static wire::PathRules rules() {
    wire::PathRules rules;
    rules.nominal_period = kSamplePeriod;
    return rules;
  }
  [[nodiscard]] LinkTime time() const { return rig.now - began; }

  /// One millisecond: what arrived, the client's step, a tick.
  void step() {
    while (auto packet = udp_up.receive(time())) {
      const auto received = server.receive(packet->second, server_sees, to_wire(rig.now));
      if (received.message) accept(*received.message, server::Carrier::kUdp);
    }
    while (auto packet = stream_up.receive(time())) accept(packet->second, server::Carrier::kGrpc);
    while (auto packet = udp_down.receive(time())) {
      on_client_change(client.receive(packet->second, client_sees, to_wire(rig.now)).change);
    }
    on_client_change(client.step(to_wire(rig.now)));
    static_cast<void>(server.step(to_wire(rig.now)));
    if (time() >= next_sample) publish();
    if (rig.state() == core::DeviceState::kArmed && time() % 50ms == 0ms) {
      static_cast<void>(rig.sessions->engage("s1", [](const auto&) {}));
    }
    rig.tick();
  }

  void publish() {
    next_sample += kSamplePeriod;
    const double phase = std::chrono::duration<double>(time()).count() * 6.0;
    newest = packed(++seq, 0.01 + 0.002 * std::sin(phase));
    if (!client.send(newest)) stream_up.send(newest, time());
  }
  void on_client_change(wire::PathChange change) {
    if (change == wire::PathChange::kSilent || change == wire::PathChange::kLossy) {
      ++fallbacks;
      stream_up.send(newest, time());
    }
  }
  void accept(wire::ConstBytes bytes, server::Carrier carrier) {
    const double position[2] = {std::bit_cast<double>(wire::get_u64(bytes.subspan(8))), 0.0};
    server::ProxyCandidate candidate;
    candidate.epoch = lease.epoch;
    candidate.seq = wire::get_u64(bytes);
    candidate.mode = core::ProxyMode::kHeld;
    candidate.position = position;
    candidate.position_size = 2;
    candidate.carrier = carrier;
    const auto verdict = rig.sessions->ingress().accept(candidate, rig.now);
    if (verdict == server::IngressVerdict::kAccepted ||
        verdict == server::IngressVerdict::kBacklog) {
      last_accepted = rig.now;
      ++accepted;
    }
  }

  const Scenario scenario;
  wire::PathKeys keys = wire::fresh_keys();
  wire::PeerAddress client_sees{{}, 1}, server_sees{{}, 2};
  DeviceRig rig{rig_config(), {}, kStart};
  core::TimePoint began{}, last_accepted{};
  server::Lease lease{};
  ImpairedLink udp_up, udp_down;
  ReliableLink stream_up;
  wire::PathEnd client, server;
  LinkTime next_sample{0};
  std::uint64_t seq{0}, accepted{0};
  Packet newest{};
  int fallbacks{0};
};

class VirtualMatrix : public testing::TestWithParam<Scenario> {};

TEST_P(VirtualMatrix, TheContractHoldsAtEveryTick) {
  World world(GetParam());
  core::TickRecord before = world.rig.newest();
  bool engaged = false;
  while (world.time() < GetParam().duration) {
    world.step();
    const core::TickRecord now = world.rig.newest();
    const auto at = world.time();
    ASSERT_GE(now.proxy_seq, now.proxy_mode == core::ProxyMode::kNone ? 0 : before.proxy_seq)
        << at.count();
    // The force moves no faster than the slew limit, but where it is taken away.
    const double step = now.tau_a[0] - before.tau_a[0];
    if (std::abs(now.tau_a[0]) > std::abs(before.tau_a[0])) {
      ASSERT_LE(std::abs(step), kSlewPerTick + 1e-9) << at.count();
    }
    // The levels at their ages, and what each allows.
    if (now.proxy_mode != core::ProxyMode::kNone) {
      ASSERT_EQ(now.staleness, core::staleness(now.proxy_age, {}, world.lease.staleness));
      ASSERT_LE(now.gain, core::ladder(now.proxy_age, world.lease.staleness) + 1e-12);
    }
    if (now.input.now - world.last_accepted > 200ms) {
      ASSERT_EQ(now.tau_elastic[0], 0.0) << at.count();
    }
    ASSERT_EQ(now.faults.bits(), 0U);
    engaged = engaged || now.state == core::DeviceState::kEngaged;
    before = now;
  }
  EXPECT_GT(world.accepted, 0U);
  EXPECT_TRUE(engaged);
}

INSTANTIATE_TEST_SUITE_P(Shipped, VirtualMatrix, testing::ValuesIn(shipped_scenarios()),
                         [](const auto& test) { return test.param.name; });

Scenario shipped(const std::string& name) {
  return read_scenario(HAPTIC_SOURCE_DIR "/tests/relay/scenarios/" + name + ".textproto");
}

/// Runs to `until`; the largest age of the proxy in use from `from` on.
core::Duration oldest_proxy(World& world, LinkTime from, LinkTime until) {
  core::Duration oldest{0};
  while (world.time() < until) {
    world.step();
    if (world.time() > from) oldest = std::max(oldest, world.rig.newest().proxy_age);
  }
  return oldest;
}

TEST(VirtualMatrixRow, BlockedUdpCostsNoMoreThanAHold) {
  World world(shipped("udp_blocked"));
  EXPECT_LT(oldest_proxy(world, 1s, 12s), world.lease.staleness.fade_end);
  EXPECT_EQ(world.fallbacks, 1);
  EXPECT_EQ(world.rig.state(), core::DeviceState::kEngaged);
  EXPECT_EQ(world.rig.sessions->ingress().carrier(), server::Carrier::kUdp);
}

TEST(VirtualMatrixRow, BlockedTcpIsNotFelt) {
  World world(shipped("tcp_blocked"));
  EXPECT_LE(oldest_proxy(world, 1s, 12s), kSamplePeriod + 1ms);
  EXPECT_EQ(world.fallbacks, 0);
}

TEST(VirtualMatrixRow, LossUpTo10PercentStaysOnUdpAndFullyEngaged) {
  for (const char* name : {"loss_01", "loss_05", "loss_10"}) {
    World world(shipped(name));
    // Five in a row are one in 100 000 at 10 %.
    EXPECT_LE(oldest_proxy(world, 2s, 10s), 5 * kSamplePeriod + 1ms) << name;
    EXPECT_EQ(world.rig.state(), core::DeviceState::kEngaged) << name;
    EXPECT_EQ(world.rig.sessions->ingress().carrier(), server::Carrier::kUdp) << name;
  }
}

TEST(VirtualMatrixRow, ADuplicateIsRejectedByTheWindowNotByTheDoor) {
  World world(shipped("duplicate_100"));
  static_cast<void>(oldest_proxy(world, 0s, 5s));
  EXPECT_GT(world.server.counters().duplicate(), 300U);
  EXPECT_EQ(world.rig.sessions->ingress().counters().old_sequence, 0U);
}

TEST(VirtualMatrixRow, ABackLogIsNotRenderedAsFresh) {
  World world(shipped("stall_backlog"));
  bool backlog = false;
  while (world.time() < 3s) {
    world.step();
    backlog = backlog || world.rig.sessions->ingress().counters().backlog > 0;
    if (world.time() > 2200ms && world.time() < 2300ms) {
      EXPECT_EQ(world.rig.newest().tau_elastic[0], 0.0);  // 180 ms and more without a sample
    }
  }
  EXPECT_TRUE(backlog);
}

}  // namespace
}  // namespace haptic::test
