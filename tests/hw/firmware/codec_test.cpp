/// The board's codec (C99) against the document's vectors. tests/fuzz holds it to the server's
/// codec (C++) on damage.
#include <gtest/gtest.h>
#include <vector>

#include "hw/firmware/haptic_frame.h"
#include "tests/hw/board/vectors.hpp"

namespace haptic::hw::board {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(FirmwareCodec, HasTheSizesOfTheServers) {
  EXPECT_EQ(HF_MAX_PAYLOAD, kMaxPayload);
  EXPECT_EQ(HF_MAX_WIRE, kMaxWire);
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

}  // namespace
}  // namespace haptic::hw::board
