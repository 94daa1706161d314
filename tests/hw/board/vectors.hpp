#pragma once
/// The test vectors of hw/README.md, as they stand there.

#include <cstdint>
#include <string>
#include <vector>

namespace haptic::test {

struct Vector {
  std::string name{};
  std::uint8_t type{0};  ///< hf_type
  std::uint32_t seq{0};
  std::vector<std::uint8_t> payload{};
  std::vector<std::uint8_t> wire{};
};

/// Throws std::runtime_error where the document has none, or one that cannot be read.
[[nodiscard]] const std::vector<Vector>& vectors();
/// The first of that name; throws where there is none.
[[nodiscard]] const Vector& vector(const std::string& name);

}  // namespace haptic::test
