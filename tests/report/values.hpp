#pragma once
/// Two numbers in one argument, "A,B", and the words the subcommands share.

#include <array>
#include <initializer_list>
#include <string>
#include <string_view>

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

struct Pair {
  double first{0.0};
  double second{0.0};
};

/// How CLI11 reads a Pair: two finite numbers with a comma between and nothing else.
bool lexical_cast(const std::string& text, Pair& pair);

/// "A,B", as an option shows its default.
[[nodiscard]] std::string to_string(const Pair& pair);

}  // namespace haptic::report
