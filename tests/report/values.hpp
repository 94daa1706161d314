#pragma once
/// Two numbers in one argument, "A,B", and the words the subcommands share.

#include <array>
#include <string>

#include "haptic/core/rendering/renderer_kind.hpp"

namespace haptic::report {

inline constexpr double kDegree = 0.017453292519943295;  ///< rad

inline constexpr std::array<core::RendererKind, 4> kMethods{
    core::RendererKind::kStandard, core::RendererKind::kNullSpace,
    core::RendererKind::kSubspaceLinear, core::RendererKind::kSubspaceExact};

struct Pair {
  double first{0.0};
  double second{0.0};
};

/// How CLI11 reads a Pair: two finite numbers with a comma between and nothing else.
bool lexical_cast(const std::string& text, Pair& pair);

/// "A,B", as an option shows its default.
[[nodiscard]] std::string to_string(const Pair& pair);

}  // namespace haptic::report
