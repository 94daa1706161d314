#pragma once
/// The renderers by name, the paper's and our own; the numbers are stable (recordings, wire).

#include <array>
#include <cstdint>
#include <string_view>

namespace haptic::core {

enum class RendererKind : std::uint8_t {
  kStandard = 1,        ///< Eq. (1)
  kNullSpace = 2,       ///< Eq. (3)-(4)
  kSubspaceLinear = 3,  ///< Eq. (7)-(8)
  kSubspaceExact = 4,   ///< Eq. (6)
  kPerContact = 5,      ///< core/METHOD.md#rendering-per-contact
};

/// Every renderer, in the order of its number.
inline constexpr std::array kRenderers{RendererKind::kStandard, RendererKind::kNullSpace,
                                       RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact,
                                       RendererKind::kPerContact};

/// The paper's, which need neither contacts nor limits: what a recording compares.
inline constexpr std::array kPaperRenderers{RendererKind::kStandard, RendererKind::kNullSpace,
                                            RendererKind::kSubspaceLinear,
                                            RendererKind::kSubspaceExact};

/// "subspace_linear", ...: also the name of its message in a scene.
[[nodiscard]] std::string_view name(RendererKind kind) noexcept;

/// True if it displays the stiffness Z_q, or less; the baselines have a virtual stiffness Z_x
/// instead.
[[nodiscard]] constexpr bool displays_Z_q(RendererKind kind) noexcept {
  return kind != RendererKind::kStandard && kind != RendererKind::kNullSpace;
}
/// True if it can render a Z_q that is not diagonal.
[[nodiscard]] constexpr bool renders_Z_q(RendererKind kind) noexcept {
  return kind == RendererKind::kSubspaceLinear || kind == RendererKind::kSubspaceExact;
}

}  // namespace haptic::core
