/// The frames of the serial link, of board and host.
#include "hw/firmware/haptic_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "tests/hw/board/frames.hpp"
#include "tests/hw/board/vectors.hpp"

namespace haptic::hw::board {
namespace {

using Bytes = std::vector<std::uint8_t>;
using test::wire_of;

struct Seen {
  std::vector<std::uint32_t> seqs{};  ///< of the frames
  int malformed{0}, bad_crc{0};
  [[nodiscard]] int rejected() const { return malformed + bad_crc; }
};

Seen decode(const Bytes& stream) {
  hf_decoder decoder{};
  Seen seen;
  for (const std::uint8_t byte : stream) {
    const hf_event event = hf_push(&decoder, byte);
    if (event == HF_FRAME) seen.seqs.push_back(decoder.seq);
    if (event == HF_MALFORMED) ++seen.malformed;
    if (event == HF_BAD_CRC) ++seen.bad_crc;
  }
  return seen;
}

/// A frame to stand before and behind the damaged one, with a seq that no vector has.
Bytes neighbour(std::uint32_t seq) {
  return wire_of(HF_STATE, seq, Bytes{1, 0, 2, 0, 0, 3});
}

constexpr std::uint32_t kBefore = 700, kBehind = 701;

Seen decode_between_neighbours(const Bytes& damaged) {
  Bytes stream = neighbour(kBefore);
  stream.insert(stream.end(), damaged.begin(), damaged.end());
  const Bytes behind = neighbour(kBehind);
  stream.insert(stream.end(), behind.begin(), behind.end());
  return decode(stream);
}

TEST(Crc32c, GivesThePublishedCheckValues) {
  const auto crc_of = [](const Bytes& bytes) { return hf_crc32c(bytes.data(), bytes.size()); };
  const std::string digits = "123456789";
  const Bytes check(digits.begin(), digits.end());
  EXPECT_EQ(crc_of(check), 0xE3069283U);
  // RFC 3720, B.4: 32 bytes of zeros, of ones, rising.
  EXPECT_EQ(crc_of(Bytes(32, 0x00)), 0x8A9136AAU);
  EXPECT_EQ(crc_of(Bytes(32, 0xFF)), 0x62A8AB43U);
  Bytes rising(32);
  for (std::size_t i = 0; i < rising.size(); ++i) rising[i] = static_cast<std::uint8_t>(i);
  EXPECT_EQ(crc_of(rising), 0x46DD794EU);
}

TEST(FrameCodec, EncodesTheDocumentsVectors) {
  for (const test::Vector& vector : test::vectors()) {
    EXPECT_EQ(wire_of(vector.type, vector.seq, vector.payload), vector.wire) << vector.name;
  }
}

TEST(FrameCodec, EveryFrameTypeHasAVector) {
  std::set<std::uint8_t> types;
  for (const test::Vector& vector : test::vectors()) types.insert(vector.type);
  EXPECT_EQ(types.size(), 8U);
}

TEST(FrameCodec, DecodesTheDocumentsVectors) {
  for (const test::Vector& vector : test::vectors()) {
    hf_decoder decoder{};
    for (std::size_t i = 0; i + 1 < vector.wire.size(); ++i) {
      ASSERT_EQ(hf_push(&decoder, vector.wire[i]), HF_NONE) << vector.name << " byte " << i;
    }
    ASSERT_EQ(hf_push(&decoder, vector.wire.back()), HF_FRAME) << vector.name;
    EXPECT_EQ(decoder.type, vector.type);
    EXPECT_EQ(decoder.seq, vector.seq);
    const auto payload = test::payload_of(decoder);
    EXPECT_EQ(Bytes(payload.begin(), payload.end()), vector.payload) << vector.name;
  }
}

TEST(FrameCodec, PayloadsRoundTrip) {
  for (const std::uint8_t fill : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{0xFF}}) {
    for (std::size_t length = 0; length <= HF_MAX_PAYLOAD; ++length) {
      const Bytes payload(length, fill);
      const Bytes wire = wire_of(HF_STATE, 0x01000001U, payload);
      ASSERT_EQ(wire.size(), length + HF_OVERHEAD + 3);
      ASSERT_EQ(std::count(wire.begin(), wire.end(), 0), 2);
      hf_decoder decoder{};
      hf_event event = HF_NONE;
      for (const std::uint8_t byte : wire) event = hf_push(&decoder, byte);
      ASSERT_EQ(event, HF_FRAME);
      const auto back = test::payload_of(decoder);
      ASSERT_EQ(Bytes(back.begin(), back.end()), payload);
    }
  }
}

TEST(FrameCodec, LongPayloadsAreNotEncoded) {
  EXPECT_TRUE(wire_of(HF_STATE, 1, Bytes(HF_MAX_PAYLOAD + 1, 7)).empty());
}

TEST(FrameCodec, ABitFlipCostsOneFrame) {
  for (const test::Vector& vector : test::vectors()) {
    for (std::size_t bit = 0; bit < 8 * vector.wire.size(); ++bit) {
      Bytes damaged = vector.wire;
      damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
      const Seen seen = decode_between_neighbours(damaged);
      ASSERT_EQ(seen.seqs, (std::vector<std::uint32_t>{kBefore, kBehind}))
          << vector.name << " bit " << bit;
      ASSERT_GE(seen.rejected(), 1) << vector.name << " bit " << bit;
    }
  }
}

TEST(FrameCodec, ATruncationCostsOneFrame) {
  for (const test::Vector& vector : test::vectors()) {
    const auto body = static_cast<std::ptrdiff_t>(vector.wire.size()) - 2;
    for (std::ptrdiff_t kept = 0; kept < body; ++kept) {
      const auto begin = vector.wire.begin();
      const Bytes head(begin, begin + 1 + kept);                          // its end is missing
      const Bytes tail(vector.wire.end() - 1 - kept, vector.wire.end());  // its beginning is
      for (const Bytes& damaged : {head, tail}) {
        const Seen seen = decode_between_neighbours(damaged);
        ASSERT_EQ(seen.seqs, (std::vector<std::uint32_t>{kBefore, kBehind}))
            << vector.name << " kept " << kept;
        ASSERT_EQ(seen.rejected(), kept > 0 ? 1 : 0) << vector.name << " kept " << kept;
      }
    }
  }
}

TEST(FrameCodec, ALostZeroLosesNoFrame) {
  for (const test::Vector& vector : test::vectors()) {
    for (const Bytes& damaged : {Bytes(vector.wire.begin() + 1, vector.wire.end()),
                                 Bytes(vector.wire.begin(), vector.wire.end() - 1)}) {
      const Seen seen = decode_between_neighbours(damaged);
      EXPECT_EQ(seen.seqs, (std::vector<std::uint32_t>{kBefore, vector.seq, kBehind}));
      EXPECT_EQ(seen.rejected(), 0);
    }
  }
}

TEST(FrameCodec, ADroppedByteIsDetected) {
  for (const test::Vector& vector : test::vectors()) {
    for (std::size_t at = 1; at + 1 < vector.wire.size(); ++at) {
      Bytes damaged = vector.wire;
      damaged.erase(damaged.begin() + static_cast<std::ptrdiff_t>(at));
      const Seen seen = decode_between_neighbours(damaged);
      ASSERT_EQ(seen.seqs, (std::vector<std::uint32_t>{kBefore, kBehind})) << vector.name;
      ASSERT_EQ(seen.rejected(), 1) << vector.name << " byte " << at;
    }
  }
}

TEST(FrameCodec, EndlessNoiseIsOneMalformedFrame) {
  const Seen seen = decode_between_neighbours(Bytes(100000, 0x55));
  EXPECT_EQ(seen.seqs, (std::vector<std::uint32_t>{kBefore, kBehind}));
  EXPECT_EQ(seen.malformed, 1);
}

TEST(FrameCodec, ZerosBetweenFramesAreNotFrames) {
  const Seen seen = decode_between_neighbours(Bytes(1000, 0));
  EXPECT_EQ(seen.seqs.size(), 2U);
  EXPECT_EQ(seen.rejected(), 0);
}

}  // namespace
}  // namespace haptic::hw::board
