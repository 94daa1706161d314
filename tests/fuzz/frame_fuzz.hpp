#pragma once
/// Fuzzing of the serial link's codecs: streams of frames, made by the C++ and the C99 encoder,
/// with damage of every kind, are read by both decoders, which must agree on every byte.

#include <cstdint>
#include <string>

namespace haptic::test {

struct FuzzResult {
  std::string finding{};  ///< empty: none
  std::uint64_t executions{0};
  std::uint64_t frames{0}, bad_crc{0}, malformed{0};
};

/// One execution is one stream of 1 to 4 frames. The same seed gives the same streams. Findings:
/// the encoders differ, the decoders differ, an undamaged frame is not read as it was written, a
/// frame is read that nobody wrote, a frame with no damage in or beside it is lost.
[[nodiscard]] FuzzResult fuzz_frames(std::uint64_t seed, std::uint64_t executions);

}  // namespace haptic::test
