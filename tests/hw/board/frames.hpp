#pragma once
/// Frames of the serial link by hand.

#include <cstdint>
#include <span>
#include <vector>

#include "hw/firmware/haptic_frame.h"

namespace haptic::test {

/// The frame with both its zeros.
inline std::vector<std::uint8_t> wire_of(std::uint8_t type, std::uint32_t seq,
                                         std::span<const std::uint8_t> payload) {
  std::vector<std::uint8_t> wire(HF_MAX_WIRE);
  wire.resize(hf_encode(type, seq, payload.data(), payload.size(), wire.data()));
  return wire;
}

/// Payload of the frame in the decoder.
inline std::span<const std::uint8_t> payload_of(const hf_decoder& decoder) {
  return {decoder.payload, decoder.payload_length};
}

}  // namespace haptic::test
