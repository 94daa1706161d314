#pragma once
/// Lists of numbers as values with a fixed layout, and which way a sample came.

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>

#include "haptic/core/types.hpp"

namespace haptic::server {

/// Up to N numbers. `count` may be above N if they came off the wire: then they are refused.
template <std::size_t N>
struct Numbers {
  std::uint32_t count{0};
  std::array<double, N> value{};

  Numbers() = default;
  Numbers(const double* from, std::size_t size) : count(static_cast<std::uint32_t>(size)) {
    std::copy_n(from, std::min(size, N), value.begin());
  }
  Numbers(std::initializer_list<double> list) : Numbers(list.begin(), list.size()) {}

  [[nodiscard]] const double* begin() const noexcept { return value.data(); }
  [[nodiscard]] const double* end() const noexcept {
    return begin() + std::min<std::size_t>(count, N);
  }
};
using Values = Numbers<core::kMaxQ>;       ///< one per DoF, or per actuated DoF
using Coordinates = Numbers<core::kMaxX>;  ///< one per virtual coordinate

[[nodiscard]] inline Values values(const core::VecA& from) {
  return {from.data(), static_cast<std::size_t>(from.size())};
}

/// Which way a sample came.
enum class Carrier : std::uint8_t { kNone = 0, kGrpc = 1, kUdp = 2, kWebSocket = 3 };
inline constexpr std::size_t kCarriers = 4;

}  // namespace haptic::server
