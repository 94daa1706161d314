#include "hw/board/frame_codec.hpp"

#include "hw/board/byte_order.hpp"

namespace haptic::hw::board {
namespace {

constexpr std::size_t kCrcSize = 4;

constexpr std::array<std::uint32_t, 256> make_table() {
  constexpr std::uint32_t kReflected = 0x82F63B78U;
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t rest = byte;
    for (int bit = 0; bit < 8; ++bit) rest = (rest >> 1) ^ ((rest & 1U) != 0 ? kReflected : 0U);
    table[byte] = rest;
  }
  return table;
}

constexpr auto kTable = make_table();

/// COBS of at most 254 bytes: each zero becomes the distance to the next one. Returns the length.
std::size_t stuff(std::span<const std::uint8_t> body, std::uint8_t* out) noexcept {
  std::size_t code_at = 0;
  std::size_t length = 1;
  for (const std::uint8_t byte : body) {
    if (byte == 0) {
      out[code_at] = static_cast<std::uint8_t>(length - code_at);
      code_at = length++;
    } else {
      out[length++] = byte;
    }
  }
  out[code_at] = static_cast<std::uint8_t>(length - code_at);
  return length;
}

/// The inverse in place: the body ends up at chunk[1..]. False if the codes do not add up.
bool unstuff(std::span<std::uint8_t> chunk) noexcept {
  std::size_t at = 0;
  while (at < chunk.size()) {
    const std::size_t next = at + chunk[at];
    if (next > chunk.size()) return false;
    chunk[at] = 0;
    at = next;
  }
  return true;
}

}  // namespace

std::uint32_t crc32c(std::span<const std::uint8_t> bytes) noexcept {
  std::uint32_t rest = ~0U;
  for (const std::uint8_t byte : bytes) rest = (rest >> 8) ^ kTable[(rest ^ byte) & 0xFFU];
  return ~rest;
}

std::size_t encode(const Frame& frame, WireBuffer& wire) noexcept {
  if (frame.payload.size() > kMaxPayload) return 0;
  std::array<std::uint8_t, kMaxBody> body{};
  ByteWriter writer(body);
  writer(frame.type, frame.seq);
  writer.bytes(frame.payload);
  writer(crc32c(writer.written()));
  wire[0] = 0;
  const std::size_t stuffed = stuff(writer.written(), wire.data() + 1);
  wire[1 + stuffed] = 0;
  return stuffed + 2;
}

FrameDecoder::Event FrameDecoder::push(std::uint8_t byte) noexcept {
  if (byte != 0) {
    if (length_ < chunk_.size()) chunk_[length_] = byte;
    if (length_ <= chunk_.size()) ++length_;
    return Event::kNone;
  }
  if (length_ == 0) return Event::kNone;  // the zeros of two neighbours
  const Event event = finish();
  length_ = 0;
  return event;
}

FrameDecoder::Event FrameDecoder::finish() noexcept {
  if (length_ > chunk_.size() || length_ < kFrameOverhead + 1) return Event::kMalformed;
  if (!unstuff({chunk_.data(), length_})) return Event::kMalformed;
  const std::span<const std::uint8_t> body(chunk_.data() + 1, length_ - 1);
  const auto covered = body.first(body.size() - kCrcSize);
  std::uint32_t crc = 0;
  ByteReader(body.last(kCrcSize))(crc);
  if (crc != crc32c(covered)) return Event::kBadCrc;
  ByteReader head(covered);
  head(frame_.type, frame_.seq);
  frame_.payload = head.rest();
  return Event::kFrame;
}

}  // namespace haptic::hw::board
