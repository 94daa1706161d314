#include "server/base/rolling_histogram.hpp"

#include <algorithm>
#include <bit>

namespace haptic::server {
namespace {

constexpr auto kRelaxed = std::memory_order_relaxed;

/// A plain add by the only writer: no locked instruction needed.
template <typename T>
void bump(std::atomic<T>& counter) noexcept {
  counter.store(counter.load(kRelaxed) + 1, kRelaxed);
}

}  // namespace

std::size_t RollingHistogram::bucket(std::uint64_t ns) noexcept {
  constexpr std::uint64_t kLinear = 1u << kSubBits;
  if (ns < kLinear) return ns;
  const int shift = static_cast<int>(std::bit_width(ns)) - 1 - kSubBits;
  return (static_cast<std::size_t>(shift) << kSubBits) + (ns >> shift);
}

core::Duration RollingHistogram::middle(std::size_t bucket) noexcept {
  constexpr std::size_t kLinear = 1u << kSubBits;
  if (bucket < 2 * kLinear) return core::Duration(bucket);
  const std::size_t shift = (bucket >> kSubBits) - 1;
  const std::size_t mantissa = bucket - (shift << kSubBits);
  return core::Duration((mantissa << shift) + ((std::size_t{1} << shift) >> 1));
}

void RollingHistogram::next_window(core::TimePoint now) noexcept {
  window_start_ = now;
  active_ = 1 - active_;
  for (auto& count : windows_[active_].counts) count.store(0, kRelaxed);
  windows_[active_].max_ns.store(0, kRelaxed);
}

void RollingHistogram::add(core::TimePoint now, core::Duration value) noexcept {
  if (now - window_start_ >= kWindow) next_window(now);
  constexpr std::int64_t kLargest = (std::int64_t{1} << kHighestBit) - 1;
  const std::int64_t ns = std::clamp<std::int64_t>(value.count(), 0, kLargest);
  Window& window = windows_[active_];
  bump(window.counts[bucket(static_cast<std::uint64_t>(ns))]);
  if (ns > window.max_ns.load(kRelaxed)) window.max_ns.store(ns, kRelaxed);
}

Percentiles RollingHistogram::read() const noexcept {
  std::array<std::uint32_t, kBuckets> counts{};
  Percentiles answer;
  for (std::size_t i = 0; i < kBuckets; ++i) {
    counts[i] = windows_[0].counts[i].load(kRelaxed) + windows_[1].counts[i].load(kRelaxed);
    answer.count += counts[i];
  }
  answer.max = core::Duration(
      std::max(windows_[0].max_ns.load(kRelaxed), windows_[1].max_ns.load(kRelaxed)));

  // The smallest value that at least this share of all does not exceed.
  const auto percentile = [&](std::uint64_t percent) {
    const std::uint64_t rank = (answer.count * percent + 99) / 100;
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      seen += counts[i];
      if (seen >= rank && seen > 0) return std::min(middle(i), answer.max);
    }
    return core::Duration::zero();
  };
  answer.p50 = percentile(50);
  answer.p99 = percentile(99);
  return answer;
}

}  // namespace haptic::server
