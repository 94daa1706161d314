#include "haptic/wire/secure_channel.hpp"

#include <gtest/gtest.h>

#include "tests/proto/wire/channel_pair.hpp"

namespace haptic::wire {
namespace {

using namespace std::chrono_literals;
using test::bytes_of;
using test::ByteVector;
using test::ChannelPair;
using test::test_keys;
using test::TestEnd;

constexpr auto kProxy = DatagramType::kProxy;
constexpr auto kState = DatagramType::kState;

TEST(SecureChannel, CarriesBothWaysAndEveryLength) {
  ChannelPair pair;
  for (std::size_t size = 0; size <= kLargestPayload; size += 73) {
    const std::string text(size, static_cast<char>('a' + size % 26));
    EXPECT_EQ(pair.server.open(pair.client.seal(kProxy, text)), text);
    EXPECT_EQ(pair.client.open(pair.server.seal(kState, text)), text);
  }
}

TEST(SecureChannel, EveryFlippedBitIsRejected) {
  ChannelPair pair;
  const ByteVector good = pair.client.seal(kProxy, "a proxy sample");
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    ByteVector bad = good;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    EXPECT_NE(pair.server.open(bad), "a proxy sample") << "bit " << bit;
  }
  EXPECT_EQ(pair.server.open(good), "a proxy sample");  // none of them moved the window
}

TEST(SecureChannel, EveryTruncationAndExtensionIsRejected) {
  ChannelPair pair;
  const ByteVector good = pair.client.seal(kProxy, "a proxy sample");
  for (std::size_t size = 0; size < good.size(); ++size) {
    const std::string answer =
        pair.server.open({good.begin(), good.begin() + static_cast<long>(size)});
    EXPECT_EQ(answer, size < 32 ? "LENGTH" : "TAG") << size;
  }
  ByteVector longer = good;
  for (int i = 0; i < 20; ++i) {
    longer.push_back(0);
    EXPECT_EQ(pair.server.open(longer), "TAG");
  }
}

TEST(SecureChannel, RejectsAReflectedDatagram) {
  ChannelPair pair;
  EXPECT_EQ(pair.client.open(pair.client.seal(kProxy, "x")), "TYPE");
  EXPECT_EQ(pair.server.open(pair.server.seal(kState, "x")), "TYPE");
  // Types that go both ways are told apart by the keys.
  EXPECT_EQ(pair.client.open(pair.client.seal(DatagramType::kPathChallenge, "x")), "TAG");
  EXPECT_EQ(pair.server.open(pair.server.seal(DatagramType::kClose, "")), "TAG");
}

TEST(SecureChannel, RejectsAWrongKeyOrSalt) {
  const PathKeys good = test_keys(1);
  for (int part = 0; part < 2; ++part) {
    PathKeys wrong = good;
    (part == 0 ? wrong.up.key[15] : wrong.up.salt[3]) ^= 1U;
    TestEnd client(End::kClient, wrong), server(End::kServer, good);
    EXPECT_EQ(server.open(client.seal(kProxy, "x")), "TAG");
  }
}

TEST(Rekey, ServerAwaitsTheClientsNewKeys) {
  ChannelPair pair;
  pair.server.channel.rekey(test_keys(2));
  EXPECT_TRUE(pair.server.channel.rekeying());
  EXPECT_EQ(pair.client.open(pair.server.seal(kState, "old")), "old");
  EXPECT_EQ(pair.server.open(pair.client.seal(kProxy, "old")), "old");
  pair.client.channel.rekey(test_keys(2));
  EXPECT_EQ(pair.client.open(pair.server.seal(kState, "old, under way")), "old, under way");
  EXPECT_EQ(pair.server.open(pair.client.seal(kProxy, "new")), "new");
  EXPECT_FALSE(pair.server.channel.rekeying());
  EXPECT_EQ(pair.server.channel.path_id(), test_keys(2).path_id);
  EXPECT_EQ(pair.client.open(pair.server.seal(kState, "new")), "new");
}

TEST(Rekey, NewKeysRestartTheNumbers) {
  ChannelPair pair;
  for (int i = 0; i < 5; ++i) ASSERT_EQ(pair.server.open(pair.client.seal(kProxy, "x")), "x");
  pair.rekey(2);
  const ByteVector first = pair.client.seal(kProxy, "x");
  EXPECT_EQ(read_header(first).header.packet_number, 1U);
  EXPECT_EQ(pair.server.open(first), "x");
  EXPECT_EQ(pair.client.channel.sent(), 1U);
}

TEST(Rekey, OldKeysOpenForOneSecond) {
  ChannelPair pair;
  const ByteVector a = pair.client.seal(kProxy, "a"), b = pair.client.seal(kProxy, "b"),
                   replayed = pair.client.seal(kProxy, "c");
  ASSERT_EQ(pair.server.open(replayed), "c");
  pair.rekey(2);
  const TimePoint taken{10s};
  ASSERT_EQ(pair.server.open(pair.client.seal(kProxy, "new"), taken), "new");
  EXPECT_EQ(pair.server.open(a, taken + 999ms), "a");
  EXPECT_EQ(pair.server.open(replayed, taken + 999ms), "DUPLICATE");
  EXPECT_EQ(pair.server.open(b, taken + 1s), "UNKNOWN_PATH");
}

TEST(Rekey, ClientForgetsOldKeysInTime) {
  ChannelPair pair;
  const ByteVector a = pair.server.seal(kState, "a"), b = pair.server.seal(kState, "b"),
                   c = pair.server.seal(kState, "c");
  pair.rekey(2);
  EXPECT_EQ(pair.client.open(a, TimePoint(5s)), "a");  // the server has not changed over yet
  ASSERT_EQ(pair.server.open(pair.client.seal(kProxy, "new")), "new");
  ASSERT_EQ(pair.client.open(pair.server.seal(kState, "new"), TimePoint(10s)), "new");
  EXPECT_EQ(pair.client.open(b, TimePoint(10s + 999ms)), "b");
  EXPECT_EQ(pair.client.open(c, TimePoint(11s)), "UNKNOWN_PATH");
}

/// A datagram under `keys` whose number is past the half of what a key bears.
ByteVector leap(const PathKeys& keys) {
  Sealer sealer(keys.path_id, keys.up, Sealer::kPacketsPerKey / 2 + 1);
  ByteVector out(kLargestDatagram);
  out.resize(sealer.seal(kProxy, bytes_of("leap"), out));
  return out;
}

TEST(Rekey, LeapingNumbersRekeyOncePerMinute) {
  TestEnd server(End::kServer, test_keys(1));
  const TimePoint now{10s};
  EXPECT_FALSE(server.channel.wants_rekey(now));
  ASSERT_EQ(server.open(leap(test_keys(1)), now), "leap");
  EXPECT_TRUE(server.channel.wants_rekey(now));
  server.channel.rekey(test_keys(2));
  EXPECT_FALSE(server.channel.wants_rekey(now));  // handed out, not used yet
  ASSERT_EQ(server.open(leap(test_keys(2)), now), "leap");
  EXPECT_FALSE(server.channel.wants_rekey(now));
  EXPECT_FALSE(server.channel.wants_rekey(now + 59'999ms));
  EXPECT_TRUE(server.channel.wants_rekey(now + 60s));
}

TEST(Rekey, ChannelKnowsItsPathIds) {
  ChannelPair pair;
  const auto known = [&](TimePoint now) {
    std::string ids;
    for (std::uint8_t seed = 1; seed <= 3; ++seed) {
      if (pair.server.channel.knows(test_keys(seed).path_id, now)) ids += std::to_string(seed);
    }
    return ids;
  };
  EXPECT_EQ(known(TimePoint(9s)), "1");
  pair.rekey(2);
  EXPECT_EQ(known(TimePoint(10s)), "12");
  ASSERT_EQ(pair.server.open(pair.client.seal(kProxy, "new"), TimePoint(10s)), "new");
  EXPECT_EQ(known(TimePoint(10'999ms)), "12");
  EXPECT_EQ(known(TimePoint(11s)), "2");
  pair.server.channel.rekey(test_keys(3));
  EXPECT_EQ(known(TimePoint(12s)), "23");
}

}  // namespace
}  // namespace haptic::wire
