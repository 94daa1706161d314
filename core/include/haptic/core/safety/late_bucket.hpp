#pragma once
/// Many small lags add up to a fault: +5 per deadline passed over, -1 per 20 ticks on time, full at
/// PipelineConfig::late_bucket_full, by default 100 (proto/README.md#states-of-a-device).

#include <algorithm>
#include <cstdint>

namespace haptic::core {

class LateBucket {
 public:
  static constexpr int kPerSkippedTick = 5;
  static constexpr int kGoodTicksPerDrop = 20;
  static constexpr int kFull = 100;

  explicit LateBucket(int full = kFull) : full_(full) {}

  void tick(std::uint32_t skipped) noexcept {
    if (skipped > 0) {
      const std::uint32_t worth_counting = std::min<std::uint32_t>(skipped, 1000);
      level_ = std::min(full_, level_ + kPerSkippedTick * static_cast<int>(worth_counting));
      good_ = 0;
    } else if (++good_ >= kGoodTicksPerDrop) {
      good_ = 0;
      level_ = std::max(0, level_ - 1);
    }
  }
  [[nodiscard]] bool full() const noexcept { return level_ >= full_; }
  [[nodiscard]] int level() const noexcept { return level_; }

 private:
  int full_;
  int level_{0};
  int good_{0};
};

}  // namespace haptic::core
