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

}  // namespace haptic::core
