/// The row of tests/relay/README.md#rows with an attacker who can send anything, on virtual time.
/// That each kind of forgery is rejected is tested in tests/proto/wire; here nothing of it is felt.

#include <gtest/gtest.h>

#include "tests/relay/matrix_table.hpp"
#include "tests/relay/virtual_world.hpp"

namespace haptic::test {
namespace {

constexpr LinkTime kAttackFrom = 2s;
constexpr LinkTime kAttackTo = 4s;
constexpr wire::PeerAddress kAttacker{{}, 666};

/// 100 datagrams: random bytes, every other one with a valid header, a damaged copy of a genuine
/// one and a repeated one.
std::vector<Packet> forged(Random& random, std::uint32_t path_id, const std::vector<Packet>& seen) {
  std::vector<Packet> all(98);
  for (Packet& junk : all) {
    junk.resize(random.next() % 1300);
    for (auto& byte : junk) byte = static_cast<std::uint8_t>(random.next());
    if (random.next() % 2 == 0 || junk.size() < wire::kHeaderSize) continue;
    wire::write_header({wire::DatagramType::kProxy, path_id, 1'000'000 + random.next() % 1000},
                       std::span<std::uint8_t, wire::kHeaderSize>(junk.data(), 16));
  }
  all.push_back(seen.back());
  const std::uint64_t bit = random.next() % (8 * all.back().size());
  all.back()[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
  all.push_back(seen[random.next() % (seen.size() - 100)]);  // the newest may be on their way
  return all;
}

/// The same world with and without the attack gives the same force to the bit, at every tick, and
/// the server sends nothing to any other address than the client's.
TEST(VirtualAttack, NoForgeryChangesTheForce) {
  MatrixRow row("virtual/junk_100000_per_s",
                "junk, forgeries and replays: each rejected; force identical to the bit; no reply");
  const Scenario scenario = shipped_scenario("delay_10ms");
  VirtualWorld peace{scenario}, war{scenario};
  std::vector<Packet> seen;
  war.on_wire = [&](Packet& packet) { seen.push_back(packet); };
  Random random(11);
  std::uint64_t rejected = 0;
  while (peace.time() < kAttackTo + 500ms) {
    peace.step();
    if (war.time() >= kAttackFrom && war.time() < kAttackTo) {
      for (const Packet& packet : forged(random, war.keys.path_id, seen)) {
        ASSERT_NE(war.deliver(packet, kAttacker), wire::Rejection::kNone);
        ++rejected;
      }
    }
    war.step();
    ASSERT_EQ(war.force(), peace.force()) << war.time().count();
    ASSERT_EQ(war.rig.newest().proxy.age, peace.rig.newest().proxy.age);
  }
  ASSERT_EQ(peace.rig.state(), core::LifecycleState::kEngaged);
  ASSERT_GT(peace.force(), 0.5);
  ASSERT_EQ(war.answered.size(), peace.answered.size());
  EXPECT_EQ(rejected, 200'000U);
  for (const auto why : {wire::Rejection::kTag, wire::Rejection::kDuplicate}) {
    EXPECT_GT(war.server.counters().rejections(why), 100U) << wire::name(why);
  }
  row.got(std::to_string(rejected) + " rejected");
}

}  // namespace
}  // namespace haptic::test
