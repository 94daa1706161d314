#include "hw/board/frame_codec.hpp"

#include <algorithm>

#include "hw/board/byte_order.hpp"
#include "hw/board/crc32c.hpp"

namespace haptic::hw::board {
namespace {

constexpr std::size_t kCrcSize = 4;

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

/// The inverse in place: the body ends up at chunk[1..]. False where the codes do not add up.
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

std::size_t encode(const Frame& frame, WireBuffer& wire) noexcept {
  if (frame.payload.size() > kMaxPayload) return 0;
  std::array<std::uint8_t, kMaxBody> body{};
  ByteWriter writer(body);
  writer.u8(static_cast<std::uint8_t>(frame.type));
  writer.u32(frame.seq);
  writer.bytes(frame.payload);
  writer.u32(crc32c(writer.written()));
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
  ByteReader tail(body.last(kCrcSize));
  if (tail.u32() != crc32c(covered)) return Event::kBadCrc;
  ByteReader head(covered);
  frame_.type = static_cast<FrameType>(head.u8());
  frame_.seq = head.u32();
  frame_.payload = head.rest();
  return Event::kFrame;
}

}  // namespace haptic::hw::board
