#pragma once
/// Common part of the loop's tests: when it starts, and a listener that keeps every record.

#include <vector>

#include "haptic/core/time.hpp"
#include "server/owner/telemetry/telemetry.hpp"

namespace haptic::test {

inline constexpr core::TimePoint kStart{std::chrono::hours(2)};

class RecordKeeper final : public server::RecordListener {
 public:
  void on_record(const core::TickRecord& record) override { records.push_back(record); }
  std::vector<core::TickRecord> records{};
};

}  // namespace haptic::test
