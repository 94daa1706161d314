#pragma once
/// The test vectors of hw/README.md, as they stand there.

#include <cstdint>
#include <string>
#include <vector>

#include "hw/board/frame_codec.hpp"

namespace haptic::test {

struct Vector {
  std::string name{};
  hw::board::FrameType type{};
  std::uint32_t seq{0};
  std::vector<std::uint8_t> payload{};
  std::vector<std::uint8_t> wire{};
  [[nodiscard]] hw::board::Frame frame() const { return {type, seq, payload}; }
};

/// Throws std::runtime_error where the document has none, or one that cannot be read.
[[nodiscard]] const std::vector<Vector>& vectors();
/// The first of that name; throws where there is none.
[[nodiscard]] const Vector& vector(const std::string& name);

}  // namespace haptic::test
