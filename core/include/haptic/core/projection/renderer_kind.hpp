#pragma once
/// The paper's renderers by name; the numbers are stable (recordings, wire).

#include <cstdint>
#include <string_view>

namespace haptic::core {

enum class RendererKind : std::uint8_t {
  kStandard = 1,        ///< Eq. (1)
  kNullSpace = 2,       ///< Eq. (3)-(4)
  kSubspaceLinear = 3,  ///< Eq. (7)-(8)
  kSubspaceExact = 4,   ///< Eq. (6)
};

[[nodiscard]] std::string_view name(RendererKind kind) noexcept;  ///< "subspace_linear", ...

/// True of those that display Z_q; the baselines have a virtual stiffness Z_x of their own.
[[nodiscard]] constexpr bool renders_Z_q(RendererKind kind) noexcept {
  return kind == RendererKind::kSubspaceLinear || kind == RendererKind::kSubspaceExact;
}

}  // namespace haptic::core
