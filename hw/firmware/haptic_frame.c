#include "haptic_frame.h"

/* Sixteen entries instead of 256: 64 bytes of flash, two look-ups per byte. Entry n is the CRC-32C
 * remainder of the four bits n (reflected polynomial 0x82F63B78). */
static const uint32_t crc_of_nibble[16] = {0x00000000u, 0x105ec76fu, 0x20bd8edeu, 0x30e349b1u,
                                           0x417b1dbcu, 0x5125dad3u, 0x61c69362u, 0x7198540du,
                                           0x82f63b78u, 0x92a8fc17u, 0xa24bb5a6u, 0xb21572c9u,
                                           0xc38d26c4u, 0xd3d3e1abu, 0xe330a81au, 0xf36e6f75u};

uint32_t hf_crc32c(const uint8_t* bytes, size_t length) {
  uint32_t rest = 0xFFFFFFFFu;
  for (size_t i = 0; i < length; ++i) {
    rest ^= bytes[i];
    rest = (rest >> 4) ^ crc_of_nibble[rest & 15u];
    rest = (rest >> 4) ^ crc_of_nibble[rest & 15u];
  }
  return ~rest;
}

uint8_t* hf_put_u16(uint8_t* to, uint16_t value) {
  to[0] = (uint8_t)(value & 0xFFu);
  to[1] = (uint8_t)(value >> 8);
  return to + 2;
}

uint8_t* hf_put_u32(uint8_t* to, uint32_t value) {
  return hf_put_u16(hf_put_u16(to, (uint16_t)(value & 0xFFFFu)), (uint16_t)(value >> 16));
}

uint8_t* hf_put_u64(uint8_t* to, uint64_t value) {
  return hf_put_u32(hf_put_u32(to, (uint32_t)(value & 0xFFFFFFFFu)), (uint32_t)(value >> 32));
}

typedef union {
  float number;
  uint32_t bits;
} float_bits;

uint8_t* hf_put_f32(uint8_t* to, float value) {
  float_bits both;
  both.number = value;
  return hf_put_u32(to, both.bits);
}

uint8_t* hf_put_text(uint8_t* to, const char* text, size_t width) {
  size_t i = 0;
  for (; i < width && text[i] != '\0'; ++i) to[i] = (uint8_t)text[i];
  for (; i < width; ++i) to[i] = 0;
  return to + width;
}

uint32_t hf_get_u32(const uint8_t* from) {
  return (uint32_t)from[0] | ((uint32_t)from[1] << 8) | ((uint32_t)from[2] << 16) |
         ((uint32_t)from[3] << 24);
}

float hf_get_f32(const uint8_t* from) {
  float_bits both;
  both.bits = hf_get_u32(from);
  return both.number;
}

bool hf_is_finite(float value) {
  float_bits both;
  both.number = value;
  return (both.bits & 0x7F800000u) != 0x7F800000u;
}

size_t hf_encode(uint8_t type, uint32_t seq, const uint8_t* payload, size_t payload_length,
                 uint8_t* wire) {
  if (payload_length > HF_MAX_PAYLOAD) return 0;
  /* The body is laid down where it will stay, two bytes in: a zero and the first COBS code. */
  uint8_t* const body = wire + 2;
  const size_t covered = HF_OVERHEAD - 4u + payload_length;
  body[0] = type;
  (void)hf_put_u32(body + 1, seq);
  for (size_t i = 0; i < payload_length; ++i) body[5 + i] = payload[i];
  (void)hf_put_u32(body + covered, hf_crc32c(body, covered));

  /* COBS in place: each zero becomes the distance to the next one. */
  const size_t end = 2u + covered + 4u;
  size_t code_at = 1;
  for (size_t i = 2; i < end; ++i) {
    if (wire[i] != 0) continue;
    wire[code_at] = (uint8_t)(i - code_at);
    code_at = i;
  }
  wire[code_at] = (uint8_t)(end - code_at);
  wire[0] = 0;
  wire[end] = 0;
  return end + 1;
}

void hf_reset(hf_decoder* decoder) {
  decoder->length = 0;
}

static bool unstuff(uint8_t* chunk, size_t length) {
  size_t at = 0;
  while (at < length) {
    const size_t next = at + chunk[at];
    if (next > length) return false;
    chunk[at] = 0;
    at = next;
  }
  return true;
}

static hf_event finish(hf_decoder* decoder) {
  const size_t length = decoder->length;
  if (length > sizeof decoder->chunk || length < HF_OVERHEAD + 1u) return HF_MALFORMED;
  if (!unstuff(decoder->chunk, length)) return HF_MALFORMED;
  const uint8_t* const body = decoder->chunk + 1;
  const size_t covered = length - 1u - 4u;
  if (hf_get_u32(body + covered) != hf_crc32c(body, covered)) return HF_BAD_CRC;
  decoder->type = body[0];
  decoder->seq = hf_get_u32(body + 1);
  decoder->payload = body + 5;
  decoder->payload_length = covered - 5u;
  return HF_FRAME;
}

hf_event hf_push(hf_decoder* decoder, uint8_t byte) {
  if (byte != 0) {
    if (decoder->length < sizeof decoder->chunk) decoder->chunk[decoder->length] = byte;
    if (decoder->length <= sizeof decoder->chunk) ++decoder->length;
    return HF_NONE;
  }
  if (decoder->length == 0) return HF_NONE; /* the zeros of two neighbours */
  const hf_event event = finish(decoder);
  decoder->length = 0;
  return event;
}
