/* Frames on the serial link, the board's side: framing, CRC, resynchronisation.
 *
 *   00 | COBS( type 1 | seq 4 | payload 0..240 | CRC-32C 4 ) | 00        little-endian
 *
 * Specified in hw/README.md, "The board protocol". C99, no library, no allocation, no state but
 * what the caller owns; floats are IEEE 754 binary32. A decoder takes 256 bytes of RAM. */
#ifndef HAPTIC_FRAME_H
#define HAPTIC_FRAME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define HF_MAX_PAYLOAD 240u
#define HF_OVERHEAD 9u                             /* type, seq, CRC */
#define HF_MAX_BODY (HF_MAX_PAYLOAD + HF_OVERHEAD) /* before COBS */
#define HF_MAX_WIRE (HF_MAX_BODY + 3u)             /* one code, two zeros */

/* Below 0x80 the host speaks, from 0x80 on the board. */
enum hf_type {
  HF_HELLO = 0x01,
  HF_ARM = 0x02,
  HF_DISARM = 0x03,
  HF_COMMAND = 0x04,
  HF_IDENTITY = 0x81,
  HF_DOF = 0x82,
  HF_STATE = 0x83,
  HF_COUNTERS = 0x84
};

typedef enum {
  HF_NONE,      /* nothing ended with this byte */
  HF_FRAME,     /* type, seq and payload of the decoder hold a frame */
  HF_MALFORMED, /* no COBS, too short or too long to be a frame */
  HF_BAD_CRC
} hf_event;

typedef struct {
  uint8_t type;
  uint32_t seq;
  const uint8_t* payload; /* inside chunk, valid until the next hf_push */
  size_t payload_length;
  size_t length;                  /* read of the present frame */
  uint8_t chunk[HF_MAX_BODY + 1]; /* between two zeros */
} hf_decoder;

uint32_t hf_crc32c(const uint8_t* bytes, size_t length);

/* Writes a whole frame, both zeros included, into HF_MAX_WIRE bytes. Returns its length; 0 if
 * the payload is too long. */
size_t hf_encode(uint8_t type, uint32_t seq, const uint8_t* payload, size_t payload_length,
                 uint8_t* wire);

void hf_reset(hf_decoder* decoder);
hf_event hf_push(hf_decoder* decoder, uint8_t byte);

/* Little-endian numbers; each put returns the place after what it wrote. */
uint8_t* hf_put_u16(uint8_t* to, uint16_t value);
uint8_t* hf_put_u32(uint8_t* to, uint32_t value);
uint8_t* hf_put_u64(uint8_t* to, uint64_t value);
uint8_t* hf_put_f32(uint8_t* to, float value);
uint8_t* hf_put_text(uint8_t* to, const char* text, size_t width); /* padded with zeros */
uint32_t hf_get_u32(const uint8_t* from);
float hf_get_f32(const uint8_t* from);
bool hf_is_finite(float value);

#ifdef __cplusplus
}
#endif

#endif
