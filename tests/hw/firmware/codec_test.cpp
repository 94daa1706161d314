/// The board's codec (C99) against the document's vectors and against the server's (C++), both
/// ways.
#include <gtest/gtest.h>

#include <vector>

#include "fuzz/frame_fuzz.hpp"
#include "hw/firmware/haptic_frame.h"
#include "tests/hw/board/vectors.hpp"

namespace haptic::hw::board {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(FirmwareCodec, HasTheSizesOfTheServers) {
  EXPECT_EQ(HF_MAX_PAYLOAD, kMaxPayload);
  EXPECT_EQ(HF_MAX_WIRE, kMaxWire);
}

TEST(FirmwareCodec, GivesThePublishedCheckValue) {
  EXPECT_EQ(hf_crc32c(reinterpret_cast<const std::uint8_t*>("123456789"), 9), 0xE3069283U);
}

TEST(FirmwareCodec, EncodesAndDecodesTheDocumentsVectors) {
  for (const test::Vector& vector : test::vectors()) {
    Bytes wire(HF_MAX_WIRE);
    wire.resize(hf_encode(static_cast<std::uint8_t>(vector.type), vector.seq, vector.payload.data(),
                          vector.payload.size(), wire.data()));
    EXPECT_EQ(wire, vector.wire) << vector.name;
    hf_decoder decoder{};
    hf_event event = HF_NONE;
    for (const std::uint8_t byte : vector.wire) event = hf_push(&decoder, byte);
    ASSERT_EQ(event, HF_FRAME) << vector.name;
    EXPECT_EQ(decoder.type, static_cast<std::uint8_t>(vector.type));
    EXPECT_EQ(decoder.seq, vector.seq);
    EXPECT_EQ(Bytes(decoder.payload, decoder.payload + decoder.payload_length), vector.payload);
  }
}

TEST(FirmwareCodec, LongPayloadsAreNotEncoded) {
  const Bytes payload(HF_MAX_PAYLOAD + 1, 1);
  Bytes wire(2 * HF_MAX_WIRE);
  EXPECT_EQ(hf_encode(HF_STATE, 1, payload.data(), payload.size(), wire.data()), 0U);
}

/// Frames that the board's decoder takes from `stream`, by their numbers.
std::vector<std::uint32_t> taken(const Bytes& stream) {
  std::vector<std::uint32_t> seqs;
  hf_decoder decoder{};
  for (const std::uint8_t byte : stream) {
    if (hf_push(&decoder, byte) == HF_FRAME) seqs.push_back(decoder.seq);
  }
  return seqs;
}

/// `damaged` between two good frames, numbers 7000 and 7001: these two must come out, and nothing
/// else.
void expect_detected(const Bytes& damaged, const std::string& what) {
  const auto neighbour = [](std::uint32_t seq) {
    Bytes wire(HF_MAX_WIRE);
    wire.resize(hf_encode(HF_COMMAND, seq, wire.data(), 0, wire.data()));
    return wire;
  };
  Bytes stream = neighbour(7000);
  stream.insert(stream.end(), damaged.begin(), damaged.end());
  const Bytes behind = neighbour(7001);
  stream.insert(stream.end(), behind.begin(), behind.end());
  ASSERT_EQ(taken(stream), (std::vector<std::uint32_t>{7000, 7001})) << what;
}

TEST(FirmwareCodec, DamageCostsOneFrame) {
  for (const test::Vector& vector : test::vectors()) {
    for (std::size_t bit = 0; bit < 8 * vector.wire.size(); ++bit) {
      Bytes damaged = vector.wire;
      damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
      expect_detected(damaged, vector.name + " bit " + std::to_string(bit));
    }
    const auto body = static_cast<std::ptrdiff_t>(vector.wire.size()) - 2;
    for (std::ptrdiff_t kept = 0; kept < body; ++kept) {
      const std::string what = vector.name + " kept " + std::to_string(kept);
      expect_detected({vector.wire.begin(), vector.wire.begin() + 1 + kept}, what + " of its head");
      expect_detected({vector.wire.end() - 1 - kept, vector.wire.end()}, what + " of its tail");
    }
  }
}

// tests/fuzz/frame_fuzz_main.cpp runs the same for as long as one likes.
TEST(FirmwareCodec, BothCodecsAgreeOnDamage) {
  const test::FuzzResult result = test::fuzz_frames(/*seed=*/1, /*executions=*/50'000);
  EXPECT_EQ(result.finding, "");
  // The fuzz reaches what it is there for.
  EXPECT_GT(result.frames, 10'000U);
  EXPECT_GT(result.bad_crc, 1'000U);
  EXPECT_GT(result.malformed, 1'000U);
}

}  // namespace
}  // namespace haptic::hw::board
