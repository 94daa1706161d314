#pragma once
/// Every renderer of the paper, for tests of what all of them share.

#include "haptic/core/rendering/renderer_kind.hpp"

namespace haptic::core {

inline constexpr RendererKind kEveryRenderer[] = {RendererKind::kStandard, RendererKind::kNullSpace,
                                                  RendererKind::kSubspaceLinear,
                                                  RendererKind::kSubspaceExact};

}  // namespace haptic::core
