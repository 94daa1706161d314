#include "hw/board/clock_map.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::hw::board {
namespace {

constexpr double kMicrosecond = 1e-6;

}  // namespace

void ClockMap::begin(std::uint64_t board_us, core::TimePoint arrival) noexcept {
  restart();
  begun_ = true;
  board_0_ = last_board_ = board_us;
  arrival_0_ = arrival;
  s0_ = 1.0;
}

/// A new point at age 0, `elapsed` s after the one before.
void ClockMap::fit(double elapsed, double offset) noexcept {
  // A sample that was at age a is now at age a - elapsed.
  s2_ += elapsed * (elapsed * s0_ - 2.0 * s1_);
  s1_ -= elapsed * s0_;
  y1_ -= elapsed * y0_;
  const double kept = std::exp(-elapsed / kMemory);
  for (double* sum : {&s0_, &s1_, &s2_, &y0_, &y1_}) *sum *= kept;
  s0_ += 1.0;
  y0_ += offset;
  const double mean = y0_ / s0_;
  const double variance = s2_ - s1_ * s1_ / s0_;  // of the ages, times s0
  const double slope = (y1_ - s1_ * mean) / std::max(variance, 1e-12);
  // The slope is used only when the points span enough time to tell drift from jitter.
  const bool known = variance > s0_ * (0.1 * kMemory) * (0.1 * kMemory);
  drift_ = known ? std::clamp(slope, -kMaxDrift, kMaxDrift) : 0.0;
  offset_ = mean - drift_ * s1_ / s0_;
}

core::TimePoint ClockMap::map(std::uint64_t board_us, core::TimePoint arrival) noexcept {
  if (!begun_ || board_us < last_board_) {
    begin(board_us, arrival);
    return arrival;
  }
  const double t = static_cast<double>(board_us - board_0_) * kMicrosecond;
  const double elapsed = static_cast<double>(board_us - last_board_) * kMicrosecond;
  const double offset = core::seconds(arrival - arrival_0_) - t;
  const double above = offset - (offset_ + drift_ * elapsed);
  if (std::abs(above) > kStep) {
    begin(board_us, arrival);
    return arrival;
  }
  const bool straggler = above > std::max(kStraggler, 4.0 * deviation_);
  if (straggler && ++stragglers_in_a_row_ <= kRelearn) {
    const double line = offset_ + drift_ * elapsed - 2.0 * deviation_;
    return std::min(arrival, arrival_0_ + core::duration(t + line));
  }
  stragglers_in_a_row_ = 0;
  fit(elapsed, offset);
  last_board_ = board_us;
  const double share = std::min(1.0, elapsed / (0.1 * kMemory));
  deviation_ += share * (std::abs(offset - offset_) - deviation_);
  return std::min(arrival, arrival_0_ + core::duration(t + offset_ - 2.0 * deviation_));
}

}  // namespace haptic::hw::board
