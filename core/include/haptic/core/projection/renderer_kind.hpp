#pragma once
/// The paper's renderers by name; the numbers are stable (recordings, wire).

#include <array>
#include <cstdint>
#include <string_view>

namespace haptic::core {

enum class RendererKind : std::uint8_t {
  kStandard = 1,        ///< Eq. (1)
  kNullSpace = 2,       ///< Eq. (3)-(4)
  kSubspaceLinear = 3,  ///< Eq. (7)-(8)
  kSubspaceExact = 4,   ///< Eq. (6)
};

/// Every renderer, in the order of its number.
inline constexpr std::array kRenderers{RendererKind::kStandard, RendererKind::kNullSpace,
                                       RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact};

/// "subspace_linear", ...: also the name of its message in a scene.
[[nodiscard]] std::string_view name(RendererKind kind) noexcept;

/// True if it displays the stiffness Z_q; the baselines have a virtual stiffness Z_x instead.
[[nodiscard]] constexpr bool renders_Z_q(RendererKind kind) noexcept {
  return kind == RendererKind::kSubspaceLinear || kind == RendererKind::kSubspaceExact;
}

}  // namespace haptic::core
