#include "hw/board/frame_codec.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "vectors.hpp"

namespace haptic::hw::board {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Event = FrameDecoder::Event;

struct Seen {
  std::vector<std::uint32_t> seqs{};  ///< of the frames
  int malformed{0}, bad_crc{0};
  [[nodiscard]] int rejected() const { return malformed + bad_crc; }
};

Seen decode(const Bytes& stream) {
  FrameDecoder decoder;
  Seen seen;
  for (const std::uint8_t byte : stream) {
    const Event event = decoder.push(byte);
    if (event == Event::kFrame) seen.seqs.push_back(decoder.frame().seq);
    if (event == Event::kMalformed) ++seen.malformed;
    if (event == Event::kBadCrc) ++seen.bad_crc;
  }
  return seen;
}

Bytes wire_of(const Frame& frame) {
  WireBuffer wire;
  const std::size_t length = encode(frame, wire);
  return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
}

/// A frame to stand before and behind the damaged one, with a seq that no vector has.
Bytes neighbour(std::uint32_t seq) {
  static const Bytes payload{1, 0, 2, 0, 0, 3};
  return wire_of({FrameType::kState, seq, payload});
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
  const std::string digits = "123456789";
  const Bytes check(digits.begin(), digits.end());
  EXPECT_EQ(crc32c(check), 0xE3069283U);
  // RFC 3720, B.4: 32 bytes of zeros, of ones, rising.
  EXPECT_EQ(crc32c(Bytes(32, 0x00)), 0x8A9136AAU);
  EXPECT_EQ(crc32c(Bytes(32, 0xFF)), 0x62A8AB43U);
  Bytes rising(32);
  for (std::size_t i = 0; i < rising.size(); ++i) rising[i] = static_cast<std::uint8_t>(i);
  EXPECT_EQ(crc32c(rising), 0x46DD794EU);
}

TEST(FrameCodec, EncodesTheDocumentsVectors) {
  for (const test::Vector& vector : test::vectors()) {
    EXPECT_EQ(wire_of(vector.frame()), vector.wire) << vector.name;
  }
}

TEST(FrameCodec, EveryFrameTypeHasAVector) {
  std::set<FrameType> types;
  for (const test::Vector& vector : test::vectors()) types.insert(vector.type);
  EXPECT_EQ(types.size(), 8U);
}

TEST(FrameCodec, DecodesTheDocumentsVectors) {
  for (const test::Vector& vector : test::vectors()) {
    FrameDecoder decoder;
    for (std::size_t i = 0; i + 1 < vector.wire.size(); ++i) {
      ASSERT_EQ(decoder.push(vector.wire[i]), Event::kNone) << vector.name << " byte " << i;
    }
    ASSERT_EQ(decoder.push(vector.wire.back()), Event::kFrame) << vector.name;
    EXPECT_EQ(decoder.frame().type, vector.type);
    EXPECT_EQ(decoder.frame().seq, vector.seq);
    const auto payload = decoder.frame().payload;
    EXPECT_EQ(Bytes(payload.begin(), payload.end()), vector.payload) << vector.name;
  }
}

TEST(FrameCodec, PayloadsRoundTrip) {
  for (const std::uint8_t fill : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{0xFF}}) {
    for (std::size_t length = 0; length <= kMaxPayload; ++length) {
      const Bytes payload(length, fill);
      const Bytes wire = wire_of({FrameType::kState, 0x01000001U, payload});
      ASSERT_EQ(wire.size(), length + kFrameOverhead + 3);
      ASSERT_EQ(std::count(wire.begin(), wire.end(), 0), 2);
      FrameDecoder decoder;
      Event event = Event::kNone;
      for (const std::uint8_t byte : wire) event = decoder.push(byte);
      ASSERT_EQ(event, Event::kFrame);
      const auto back = decoder.frame().payload;
      ASSERT_EQ(Bytes(back.begin(), back.end()), payload);
    }
  }
}

TEST(FrameCodec, LongPayloadsAreNotEncoded) {
  WireBuffer wire;
  const Bytes payload(kMaxPayload + 1, 7);
  EXPECT_EQ(encode({FrameType::kState, 1, payload}, wire), 0U);
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

TEST(SequenceFilter, SkippedNumbersAreCounted) {
  SequenceFilter filter;
  filter.restart(0xFFFFFFFEU);
  EXPECT_TRUE(filter.accept(0xFFFFFFFFU));
  EXPECT_TRUE(filter.accept(0));  // wraps
  EXPECT_EQ(filter.lost(), 0U);
  EXPECT_FALSE(filter.accept(0));  // repeated
  EXPECT_TRUE(filter.accept(4));
  EXPECT_EQ(filter.lost(), 3U);
  EXPECT_FALSE(filter.accept(2));  // late
  EXPECT_FALSE(filter.accept(4U + 0x80000000U));
  EXPECT_EQ(filter.lost(), 3U);
}

}  // namespace
}  // namespace haptic::hw::board
