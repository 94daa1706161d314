#include "server/rt/loop_statistics.hpp"

#include <algorithm>
#include <bit>

namespace haptic::server {

std::size_t DurationHistogram::bucket_of(std::uint64_t ns) noexcept {
  if (ns < kParts) return static_cast<std::size_t>(ns);
  const unsigned exponent = static_cast<unsigned>(std::bit_width(ns)) - 1;  // >= 4
  const std::uint64_t part = (ns >> (exponent - 4)) & (kParts - 1);
  return std::min<std::size_t>((exponent - 3) * kParts + part, 1023);
}

core::Duration DurationHistogram::upper_edge(std::size_t bucket) noexcept {
  if (bucket < kParts) return core::Duration(static_cast<std::int64_t>(bucket));
  const std::size_t exponent = bucket / kParts + 3;
  const std::uint64_t part = bucket % kParts;
  return core::Duration(static_cast<std::int64_t>((kParts + part + 1) << (exponent - 4)));
}

void DurationHistogram::add(core::Duration value) noexcept {
  const auto ns = static_cast<std::uint64_t>(std::max<std::int64_t>(value.count(), 0));
  counts_[bucket_of(ns)].fetch_add(1, std::memory_order_relaxed);
}

void DurationHistogram::clear() noexcept {
  for (auto& count : counts_) count.store(0, std::memory_order_relaxed);
}

void DurationHistogram::add_to(std::array<std::uint64_t, 1024>& counts) const noexcept {
  for (std::size_t i = 0; i < counts.size(); ++i) {
    counts[i] += counts_[i].load(std::memory_order_relaxed);
  }
}

void SlidingPercentiles::add(core::Duration value, core::TimePoint now) noexcept {
  if (now - started_ > kWindow) {
    started_ = now;
    const unsigned next = 1 - current_.load(std::memory_order_relaxed);
    windows_[next].clear();
    current_.store(next, std::memory_order_release);
  }
  windows_[current_.load(std::memory_order_relaxed)].add(value);
}

Percentiles SlidingPercentiles::read() const noexcept {
  std::array<std::uint64_t, 1024> counts{};
  for (const DurationHistogram& window : windows_) window.add_to(counts);
  std::uint64_t total = 0;
  for (const std::uint64_t count : counts) total += count;
  Percentiles out;
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i < counts.size() && total > 0; ++i) {
    if (counts[i] == 0) continue;
    const std::uint64_t before = seen;
    seen += counts[i];
    const double edge = core::seconds(DurationHistogram::upper_edge(i)) * 1e6;
    if (before * 2 < total && seen * 2 >= total) out.p50_us = edge;
    if (before * 100 < total * 99 && seen * 100 >= total * 99) out.p99_us = edge;
    out.max_us = edge;
  }
  return out;
}

}  // namespace haptic::server
