#include "haptic/wire/link_statistics.hpp"

#include <algorithm>

namespace haptic::wire {

void LinkStatistics::accepted(std::uint64_t packet_number, std::size_t bytes,
                              TimePoint arrival) noexcept {
  ++packets_;
  ++counters_.received;
  counters_.bytes += bytes;
  if (packet_number < newest_) ++counters_.reordered;
  newest_ = std::max(newest_, packet_number);
  counters_.lost = lost_before_ + (newest_ - packets_);
  if (last_arrival_) {
    counters_.longest_gap = std::max(counters_.longest_gap, arrival - *last_arrival_);
  }
  last_arrival_ = arrival;
}

void LinkStatistics::timed(Duration sender_time, TimePoint arrival) noexcept {
  const Duration transit = arrival.time_since_epoch() - sender_time;
  if (transit_) {
    const Duration difference = std::chrono::abs(transit - *transit_);
    counters_.jitter += (difference - counters_.jitter) / 16;
  }
  transit_ = transit;
}

void LinkStatistics::renumber() noexcept {
  lost_before_ = counters_.lost;
  packets_ = newest_ = 0;
}

void RoundTrip::add(Duration rtt) noexcept {
  if (!known_) {
    known_ = true;
    smoothed_ = least_ = rtt;
    variation_ = rtt / 2;
    return;
  }
  variation_ += (std::chrono::abs(smoothed_ - rtt) - variation_) / 4;
  smoothed_ += (rtt - smoothed_) / 8;
  least_ = std::min(least_, rtt);
}

void LossReport::add(std::uint64_t packets, std::uint64_t newest, TimePoint arrival) noexcept {
  if (count_ > 0 && (newest < newest_.newest || packets < newest_.packets)) return;
  newest_ = {packets, newest, arrival};
  if (count_ > 0 && arrival - kept_[count_ - 1].arrival < kApart) return;
  if (count_ == kKept) {
    std::move(kept_.begin() + 1, kept_.end(), kept_.begin());
    --count_;
  }
  kept_[count_++] = newest_;
}

std::optional<double> LossReport::share() const noexcept {
  // The youngest of those that are a second old.
  for (std::size_t i = count_; i-- > 0;) {
    const Report& then = kept_[i];
    if (newest_.arrival - then.arrival < kOver) continue;
    const std::uint64_t sent = newest_.newest - then.newest;
    if (sent < kLeastPackets) return std::nullopt;
    const std::uint64_t came = std::min(newest_.packets - then.packets, sent);
    return 1.0 - static_cast<double>(came) / static_cast<double>(sent);
  }
  return std::nullopt;
}

}  // namespace haptic::wire
