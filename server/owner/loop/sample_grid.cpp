#include "server/owner/loop/sample_grid.hpp"

#include <algorithm>
#include <limits>

namespace haptic::server {

SampleGrid::Tick SampleGrid::wake(core::TimePoint now, core::Duration suspended,
                                  std::optional<core::TimePoint> arrival) noexcept {
  Tick tick;
  tick.by_sample = arrival && *arrival <= latest();
  const core::TimePoint due = tick.by_sample ? std::max(*arrival, earliest()) : latest();
  const core::Duration late = std::max(now - due, core::Duration::zero());
  const auto passed = late / period_;
  // A device's phase is taken from its samples; without one, the last known phase goes on.
  expected_ = (tick.by_sample ? due : expected_) + (passed + 1) * period_;
  previous_ = due + passed * period_;
  tick.report.lateness = late + suspended;
  tick.report.skipped = static_cast<std::uint32_t>(
      std::min<std::int64_t>(passed, std::numeric_limits<std::uint32_t>::max()));
  return tick;
}

}  // namespace haptic::server
