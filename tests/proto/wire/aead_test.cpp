#include "haptic/wire/aead.hpp"

#include <gtest/gtest.h>

#include <set>

#include "tests/proto/wire/channel_pair.hpp"

namespace haptic::wire {
namespace {

using test::ByteVector;
using test::from_hex;
using test::test_keys;
using test::to_hex;

TEST(FreshKeys, DifferInPartsAndBetweenCalls) {
  std::set<std::string> keys, salts;
  std::set<std::uint32_t> ids;
  for (int i = 0; i < 50; ++i) {
    const PathKeys fresh = fresh_keys();
    EXPECT_NE(fresh.path_id, 0U);
    ids.insert(fresh.path_id);
    for (const auto& direction : {fresh.up, fresh.down}) {
      keys.insert(to_hex(direction.key));
      salts.insert(to_hex(direction.salt));
    }
  }
  EXPECT_EQ(keys.size(), 100U);
  EXPECT_GE(salts.size(), 99U);  // 32 bits may meet once in a long while
  EXPECT_GE(ids.size(), 49U);
}

TEST(Sealer, OversizedDatagramUsesNoNumber) {
  Sealer sealer(7, test_keys(1).up);
  ByteVector out(kLargestDatagram + 100), payload(kLargestPayload + 1);
  EXPECT_EQ(sealer.seal(DatagramType::kProxy, payload, out), 0U);
  payload.pop_back();
  EXPECT_EQ(sealer.seal(DatagramType::kProxy, payload, Bytes(out).first(1199)), 0U);
  EXPECT_EQ(sealer.packets(), 0U);
  EXPECT_EQ(sealer.seal(DatagramType::kProxy, payload, out), 1200U);
}

TEST(Sealer, WornKeyIsReplacedAtHalfway) {
  ByteVector out(kLargestDatagram);
  Sealer half(7, test_keys(1).up, Sealer::kPacketsPerKey / 2);
  EXPECT_FALSE(half.wants_rekey());
  EXPECT_GT(half.seal(DatagramType::kClose, {}, out), 0U);
  EXPECT_TRUE(half.wants_rekey());
  Sealer last(7, test_keys(1).up, Sealer::kPacketsPerKey);
  EXPECT_EQ(last.seal(DatagramType::kClose, {}, out), 32U);
  EXPECT_EQ(last.seal(DatagramType::kClose, {}, out), 0U);
  EXPECT_EQ(last.seal(DatagramType::kClose, {}, out), 0U);
}

/// "abc" under the keys of these tests, sealed by Python's cryptography.
TEST(Opener, NoNumberAboveAKeysLast) {
  const ByteVector last =
      from_hex("68700101000000070000000100000000fa7ed039c24ef798df23488e0fe6b5c127b6b1");
  const char* const beyond[] = {
      "68700101000000070000000100000001a97903bbf3099e2a4632915223bd7167a3f00f",
      "6870010100000007ffffffffffffffffd615f026085d06bc940f28ec72d0bfb8d4a125"};
  Opener opener(7, test_keys(1).up);
  ByteVector payload(kLargestPayload);
  for (const char* hex : beyond) {
    const ByteVector bytes = from_hex(hex);
    EXPECT_EQ(opener.open(read_header(bytes).header, bytes, payload).rejection, Rejection::kTag);
  }
  EXPECT_EQ(opener.open(read_header(last).header, last, payload).rejection, Rejection::kNone);
  EXPECT_EQ(opener.newest(), Sealer::kPacketsPerKey);
}

}  // namespace
}  // namespace haptic::wire
