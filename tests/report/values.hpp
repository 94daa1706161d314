#pragma once
/// Words that the subcommands share.

#include <array>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "haptic/core/rendering/renderer_kind.hpp"

namespace haptic::report {

inline constexpr double kDegree = 0.017453292519943295;  ///< rad

inline constexpr std::array<core::RendererKind, 4> kMethods{
    core::RendererKind::kStandard, core::RendererKind::kNullSpace,
    core::RendererKind::kSubspaceLinear, core::RendererKind::kSubspaceExact};

/// Name of an enumerator that counts from 0, on the command line and in the tables.
template <typename Enum>
[[nodiscard]] std::string_view name_in(std::initializer_list<std::string_view> names,
                                       Enum value) noexcept {
  return names.begin()[static_cast<std::size_t>(value)];
}

/// Two numbers in one argument, "A,B".
using Pair = std::pair<double, double>;

}  // namespace haptic::report
