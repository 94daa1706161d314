#pragma once
/// The times that the tests of both grids of ticks begin with.

#include "haptic/core/time.hpp"

namespace haptic::test {

inline constexpr core::TimePoint kFirst{std::chrono::hours(1)};
inline constexpr core::Duration kPeriod = std::chrono::milliseconds(1);

}  // namespace haptic::test
