#include "haptic/wire/datagram.hpp"

#include <gtest/gtest.h>

#include "haptic/wire/path_message.hpp"
#include "tests/proto/wire/hex.hpp"

namespace haptic::wire {
namespace {

using test::ByteVector;
using test::from_hex;
using test::to_hex;

/// The header of the byte table, and room for a tag.
ByteVector example() {
  ByteVector bytes = from_hex("6870 01 02 a1b2c3d4 0000000000000102");
  bytes.resize(kHeaderSize + kTagSize);
  return bytes;
}

TEST(DatagramHeader, RejectsLengthsOutside32To1200) {
  ByteVector bytes = example();
  for (std::size_t size = 0; size <= 1300; ++size) {
    bytes.resize(size);
    if (size >= 16) std::copy_n(example().begin(), 16, bytes.begin());
    EXPECT_EQ(read_header(bytes).rejection,
              size >= 32 && size <= 1200 ? Rejection::kNone : Rejection::kLength)
        << size;
  }
}

TEST(DatagramHeader, RejectsWrongFirstBytesByReason) {
  const Rejection reasons[] = {Rejection::kMagic, Rejection::kMagic, Rejection::kVersion};
  for (std::size_t at = 0; at < 3; ++at) {
    for (int value = 0; value < 256; ++value) {
      ByteVector bytes = example();
      if (bytes[at] == value) continue;
      bytes[at] = static_cast<std::uint8_t>(value);
      EXPECT_EQ(read_header(bytes).rejection, reasons[at]) << at << ": " << value;
    }
  }
  for (int type = 0; type < 256; ++type) {
    ByteVector bytes = example();
    bytes[3] = static_cast<std::uint8_t>(type);
    EXPECT_EQ(read_header(bytes).rejection,
              type >= 1 && type <= 5 ? Rejection::kNone : Rejection::kType);
  }
}

TEST(DatagramHeader, TheCheapestCheckSpeaksFirst) {
  ByteVector bytes(31, 0);
  EXPECT_EQ(read_header(bytes).rejection, Rejection::kLength);
  bytes.resize(32);
  EXPECT_EQ(read_header(bytes).rejection, Rejection::kMagic);
  bytes[0] = 0x68;
  bytes[1] = 0x70;
  EXPECT_EQ(read_header(bytes).rejection, Rejection::kVersion);
  bytes[2] = 1;
  EXPECT_EQ(read_header(bytes).rejection, Rejection::kType);
}

TEST(Rejections, EachHasItsOwnName) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kRejections; ++i) {
    names.emplace_back(name(static_cast<Rejection>(i)));
    EXPECT_NE(names.back(), "UNKNOWN");
  }
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
  EXPECT_STREQ(name(static_cast<Rejection>(kRejections)), "UNKNOWN");
}

TEST(PathMessages, HaveTheBytesOfTheTable) {
  ByteVector challenge(42, 0xEE);
  write(PathChallenge{0x0102030405060708}, challenge);
  EXPECT_EQ(to_hex(challenge), "0102030405060708" + std::string(2 * 34, '0'));
  ByteVector response(41, 0xEE);
  write(PathResponse{0x0102030405060708, -2, 3, 4, 5}, response);
  EXPECT_EQ(to_hex(response),
            "0102030405060708fffffffffffffffe0000000000000003"
            "0000000000000004000000000000000500");
}

TEST(PathMessages, ReadAnyPaddingButNotTruncation) {
  ByteVector bytes(kPaddedChallenge, 0xEE);
  write(PathResponse{1, -2, 3, 4, 5}, Bytes(bytes).first(40));
  ASSERT_TRUE(read_response(bytes));
  EXPECT_EQ(read_response(bytes)->received_ns, -2);
  ASSERT_TRUE(read_challenge(bytes));
  EXPECT_EQ(read_challenge(bytes)->token, 1U);
  for (std::size_t size = 0; size < 40; ++size) {
    EXPECT_FALSE(read_challenge(ConstBytes(bytes).first(size)));
    EXPECT_FALSE(read_response(ConstBytes(bytes).first(size)));
  }
}

}  // namespace
}  // namespace haptic::wire
