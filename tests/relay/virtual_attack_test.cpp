/// The rows of tests/relay/README.md#rows with an attacker who can send anything, on virtual time.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <initializer_list>
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
  /// Forges datagrams in each millisecond of the attack, before the step. Each is rejected, for one
  /// of `reasons`.
  void run(const wire::PeerAddress& from, std::initializer_list<wire::Rejection> reasons,
           const std::function<std::vector<Packet>()>& forge) {
    while (peace.time() < kAttackTo + 500ms) {
      peace.step();
      for (const Packet& forged : attacking() ? forge() : std::vector<Packet>()) {
        const wire::Rejection why = war.deliver(forged, from);
        ASSERT_NE(std::ranges::find(reasons, why), reasons.end()) << wire::name(why);
        ++rejected;
      }
      war.step();
      ASSERT_EQ(war.force(), peace.force()) << war.time().count();
      ASSERT_EQ(war.rig.newest().proxy.age, peace.rig.newest().proxy.age);
    }
    ASSERT_EQ(peace.rig.state(), core::LifecycleState::kEngaged);
    ASSERT_GT(peace.force(), 0.5);
    ASSERT_EQ(war.answered.size(), peace.answered.size());
    row.got(std::to_string(rejected) + " rejected");
  }
  [[nodiscard]] bool attacking() const {
    return war.time() >= kAttackFrom && war.time() < kAttackTo;
  }

  explicit Siege(const std::string& name)
      : row("virtual/" + name, "each is rejected; force identical to the bit; no reply") {}
  MatrixRow row;
  Scenario scenario = shipped_scenario("delay_10ms");
  VirtualWorld peace{scenario}, war{scenario};
  std::uint64_t rejected{0};
};

using wire::Rejection;

TEST(VirtualAttack, BitFlipsChangeNothing) {
  Siege siege("bit_flips");
  Packet genuine;
  siege.war.on_wire = [&](Packet& packet) { genuine = packet; };
  siege.run(siege.war.server_sees,
            {Rejection::kMagic, Rejection::kVersion, Rejection::kType, Rejection::kUnknownPath,
             Rejection::kTag, Rejection::kDuplicate, Rejection::kTooOld},
            [&, random = Random(7)]() mutable {
              Packet damaged = genuine;
              const std::uint64_t bit = random.next() % (8 * damaged.size());
              damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
              return std::vector<Packet>{damaged};
            });
}

TEST(VirtualAttack, AWrongKeyChangesNothing) {
  Siege siege("wrong_key");
  wire::PathKeys guessed = wire::fresh_keys();
  guessed.path_id = siege.war.keys.path_id;
  wire::SecureChannel forger(wire::End::kClient, guessed);
  for (int i = 0; i < 100'000; ++i) {  // ahead of the genuine packet numbers
    Packet none(wire::kLargestDatagram);
    static_cast<void>(forger.seal(wire::DatagramType::kProxy, {}, none));
  }
  siege.run(siege.war.server_sees, {Rejection::kTag}, [&] {
    Packet forged(wire::kLargestDatagram);
    forged.resize(forger.seal(wire::DatagramType::kProxy, packed_sample(1U << 30U, 0.4), forged));
    return std::vector<Packet>{forged};
  });
}

TEST(VirtualAttack, AReplayedCaptureChangesNothing) {
  Siege siege("replayed_capture");
  std::vector<Packet> capture;
  siege.war.on_wire = [&](Packet& packet) {
    if (siege.war.time() < kAttackFrom - 100ms) capture.push_back(packet);
  };
  siege.run(siege.war.server_sees, {Rejection::kDuplicate, Rejection::kTooOld},
            [&] { return std::vector<Packet>{capture[siege.rejected % capture.size()]}; });
  ASSERT_GT(capture.size(), 100U);
}

TEST(VirtualAttack, SpoofedSourceGetsAndMovesNothing) {
  Siege siege("spoofed_source");
  std::vector<std::pair<LinkTime, Packet>> passing;
  siege.war.on_wire = [&](Packet& packet) { passing.emplace_back(siege.war.time(), packet); };
  siege.run(kAttacker, {Rejection::kDuplicate, Rejection::kTooOld}, [&, next = 0U]() mutable {
    std::vector<Packet> copies;  // just after the original
    while (passing[next].first + 11ms < siege.war.time()) copies.push_back(passing[next++].second);
    return copies;
  });
  ASSERT_GT(siege.rejected, 200U);
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
  Siege siege("junk_100000_per_s");
  siege.run(kAttacker,
            {Rejection::kLength, Rejection::kMagic, Rejection::kVersion, Rejection::kType,
             Rejection::kUnknownPath, Rejection::kTag},
            [&, random = Random(11), sent = 0U]() mutable {
              std::vector<Packet> all(100);
              for (Packet& junk : all) {
                junk.resize(random.next() % 1300);
                for (auto& byte : junk) byte = static_cast<std::uint8_t>(random.next());
                if (++sent % 2 == 0 || junk.size() < wire::kHeaderSize) continue;
                wire::write_header(
                    {wire::DatagramType::kProxy, siege.war.keys.path_id, 1'000'000 + sent},
                    std::span<std::uint8_t, wire::kHeaderSize>(junk.data(), wire::kHeaderSize));
              }
              return all;
            });
  EXPECT_EQ(siege.rejected, 200'000U);
  EXPECT_GT(siege.war.server.counters().rejections(Rejection::kTag), 10'000U);
}

}  // namespace
}  // namespace haptic::test
