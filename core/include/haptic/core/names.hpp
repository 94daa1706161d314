#pragma once
/// Names of enumerators whose numbers are stable and follow each other.

#include <array>
#include <cstddef>
#include <string_view>

namespace haptic::core {

/// names[n] belongs to the enumerator of number n; any other number is "UNKNOWN".
template <typename Enum, std::size_t N>
[[nodiscard]] constexpr std::string_view name_of(Enum e,
                                                 const std::array<std::string_view, N>& names) {
  const auto n = static_cast<std::size_t>(e);
  return n < N ? names[n] : "UNKNOWN";
}

}  // namespace haptic::core
