#pragma once
/// How a least-squares problem or a projection ended.

#include <cstdint>

namespace haptic::core {

enum class ProjectionStatus : std::uint8_t {
  kNone = 0,            ///< nothing to project: no proxy, or free
  kExact = 1,           ///< solved to rounding (closed form, or a direct linear solve)
  kConverged = 2,       ///< iterated to tolerance
  kCapped = 3,          ///< iteration cap reached; the best iterate is used
  kUnreachable = 4,     ///< no q reaches x; the constrained optimum is used
  kIllConditioned = 5,  ///< condition of the equilibrated J above 1e8
  kRankDeficient = 6,   ///< a column of J depends on the others; minimum-norm answer in metric Z_q
  kMapFailed = 7,       ///< f has no value at q: the last q* is kept
                        ///< (core/METHOD.md#map-without-a-value)
};

}  // namespace haptic::core
