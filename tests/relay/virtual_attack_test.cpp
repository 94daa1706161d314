/// The rows of tests/relay/README.md#rows with an attacker who can send anything, on virtual time.

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <utility>

#include "tests/relay/matrix_table.hpp"
#include "tests/relay/virtual_world.hpp"

namespace haptic::test {
namespace {

constexpr LinkTime kAttackFrom = 2s;
constexpr LinkTime kAttackTo = 4s;
constexpr wire::PeerAddress kAttacker{{}, 666};

/// An attack that changes nothing: the same world with and without it gives the same force to the
/// bit, at every tick, and the server sends nothing to any other address than the client's.
struct Siege {
  /// `attack` runs in each millisecond of the attack, before the step.
  void run(const std::function<void(VirtualWorld&)>& attack) {
    while (peace.time() < kAttackTo + 500ms) {
      peace.step();
      if (war.time() >= kAttackFrom && war.time() < kAttackTo) attack(war);
      war.step();
      ASSERT_EQ(war.force(), peace.force()) << war.time().count();
      ASSERT_EQ(war.rig.newest().proxy.age, peace.rig.newest().proxy.age);
    }
    ASSERT_EQ(peace.rig.state(), core::LifecycleState::kEngaged);
    ASSERT_GT(peace.force(), 0.5);
    ASSERT_EQ(war.answered.size(), peace.answered.size());
  }
  Scenario scenario = shipped_scenario("delay_10ms");
  VirtualWorld peace{scenario}, war{scenario};
};

TEST(VirtualAttack, BitFlipsChangeNothing) {
  MatrixRow row("virtual/bit_flips", "each is rejected; force identical to the bit; no reply");
  Siege siege;
  Packet genuine;
  siege.war.on_wire = [&](Packet& packet) { genuine = packet; };
  Random random(7);
  std::uint64_t flipped = 0, rejected = 0;
  siege.run([&](VirtualWorld& war) {
    Packet damaged = genuine;
    const std::uint64_t bit = random.next() % (8 * damaged.size());
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    ++flipped;
    rejected += war.deliver(damaged, war.server_sees) != wire::Rejection::kNone ? 1 : 0;
  });
  EXPECT_EQ(rejected, flipped);
  row.got(std::to_string(rejected) + " of " + std::to_string(flipped) + " rejected");
}

TEST(VirtualAttack, AWrongKeyChangesNothing) {
  MatrixRow row("virtual/wrong_key", "rejected by the tag; force identical to the bit; no reply");
  Siege siege;
  wire::PathKeys guessed = wire::fresh_keys();
  guessed.path_id = siege.war.keys.path_id;
  wire::SecureChannel forger(wire::End::kClient, guessed);
  for (int i = 0; i < 100'000; ++i) {  // ahead of the genuine packet numbers
    Packet none(wire::kLargestDatagram);
    static_cast<void>(forger.seal(wire::DatagramType::kProxy, {}, none));
  }
  std::uint64_t sent = 0;
  siege.run([&](VirtualWorld& war) {
    Packet forged(wire::kLargestDatagram);
    forged.resize(forger.seal(wire::DatagramType::kProxy, packed_sample(1U << 30U, 0.4), forged));
    ++sent;
    ASSERT_EQ(war.deliver(forged, war.server_sees), wire::Rejection::kTag);
  });
  row.got(std::to_string(sent) + " rejected by the tag");
}

TEST(VirtualAttack, AReplayedCaptureChangesNothing) {
  MatrixRow row("virtual/replayed_capture",
                "each is a duplicate or too old; force identical to the bit; no reply");
  Siege siege;
  std::vector<Packet> capture;
  siege.war.on_wire = [&](Packet& packet) {
    if (siege.war.time() < kAttackFrom - 100ms) capture.push_back(packet);
  };
  std::size_t next = 0;
  siege.run([&](VirtualWorld& war) {
    const wire::Rejection why = war.deliver(capture[next++ % capture.size()], war.server_sees);
    ASSERT_TRUE(why == wire::Rejection::kDuplicate || why == wire::Rejection::kTooOld);
  });
  ASSERT_GT(capture.size(), 100U);
  row.got(std::to_string(next) + " rejected");
}

TEST(VirtualAttack, SpoofedSourceGetsAndMovesNothing) {
  MatrixRow row("virtual/spoofed_source",
                "copies from another address: rejected; force identical to the bit; no reply");
  Siege siege;
  std::vector<std::pair<LinkTime, Packet>> passing;
  siege.war.on_wire = [&](Packet& packet) { passing.emplace_back(siege.war.time(), packet); };
  std::size_t next = 0;
  siege.run([&](VirtualWorld& war) {
    for (; passing[next].first + 11ms < war.time(); ++next) {  // just after the original
      const wire::Rejection why = war.deliver(passing[next].second, kAttacker);
      ASSERT_TRUE(why == wire::Rejection::kDuplicate || why == wire::Rejection::kTooOld);
    }
  });
  ASSERT_GT(next, 200U);
  row.got(std::to_string(next) + " rejected");
}

TEST(VirtualAttack, FasterCopierGetsNoStates) {
  MatrixRow row("virtual/spoofed_source_ahead",
                "genuine datagrams first from another address: never a state to it");
  VirtualWorld world(shipped_scenario("delay_10ms"));
  world.run(kAttackFrom);
  ASSERT_TRUE(world.server.in_use());
  world.on_wire = [&](Packet& packet) { static_cast<void>(world.deliver(packet, kAttacker)); };
  while (world.time() < kAttackTo) {
    world.step();
    // It may spoil the path, so that the stream carries; it cannot draw the states to itself.
    ASSERT_TRUE(!world.server.in_use() || world.server.address() == world.server_sees);
  }
  EXPECT_EQ(world.rig.state(), core::LifecycleState::kEngaged);
  row.got("no state sent to it in 2 s");
}

TEST(VirtualAttack, AFloodOfJunkChangesNothing) {
  MatrixRow row("virtual/junk_100000_per_s",
                "each counted by its reason; force identical to the bit; no reply");
  Siege siege;
  Random random(11);
  std::array<std::uint64_t, wire::kRejections> reasons{};
  std::uint64_t sent = 0;
  siege.run([&](VirtualWorld& war) {
    for (int i = 0; i < 100; ++i, ++sent) {
      Packet junk(random.next() % 1300);
      for (auto& byte : junk) byte = static_cast<std::uint8_t>(random.next());
      if (i % 2 == 0 && junk.size() >= wire::kHeaderSize) {
        wire::write_header({wire::DatagramType::kProxy, war.keys.path_id, 1'000'000 + sent},
                           std::span<std::uint8_t, wire::kHeaderSize>(junk.data(), 16));
      }
      ++reasons.at(static_cast<std::size_t>(war.deliver(junk, kAttacker)));
    }
  });
  EXPECT_EQ(reasons.at(0), 0U);
  EXPECT_EQ(sent, 200'000U);
  EXPECT_EQ(
      siege.war.server.counters().rejected.at(static_cast<std::size_t>(wire::Rejection::kTag)),
      reasons.at(static_cast<std::size_t>(wire::Rejection::kTag)));
  row.got(std::to_string(sent) + " rejected");
}

}  // namespace
}  // namespace haptic::test
