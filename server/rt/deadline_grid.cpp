#include "server/rt/deadline_grid.hpp"

#include <algorithm>
#include <limits>

namespace haptic::server {

core::LoopReport DeadlineGrid::wake(core::TimePoint now, core::Duration suspended) noexcept {
  const core::Duration late = std::max(now - deadline_, core::Duration::zero());
  const auto passed = late / period_;
  deadline_ += (passed + 1) * period_;

  core::LoopReport report;
  report.lateness = late + suspended;
  report.skipped = static_cast<std::uint32_t>(
      std::min<std::int64_t>(passed, std::numeric_limits<std::uint32_t>::max()));
  return report;
}

}  // namespace haptic::server
