#include "haptic/wire/clock_offset.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::wire {
namespace {

double ns(Duration duration) noexcept {
  return static_cast<double>(duration.count());
}

Duration from_ns(double value) noexcept {
  return Duration(static_cast<std::int64_t>(std::llround(value)));
}

/// Time by which the two clocks may have moved against each other over `age`.
Duration drifted(Duration age) noexcept {
  return from_ns(ClockOffset::kLargestDrift * std::abs(ns(age)));
}

/// So that differences do not overflow: 146 years of uptime, which only nonsense has.
bool plausible(Duration reading) noexcept {
  constexpr Duration kLargest{std::int64_t{1} << 62};
  return -kLargest < reading && reading < kLargest;
}

}  // namespace

std::optional<ClockOffset::Point> ClockOffset::proof(const ClockExchange& exchange) noexcept {
  if (!plausible(exchange.received) || !plausible(exchange.answered)) return std::nullopt;
  const Duration there = exchange.answered - exchange.received;
  const Duration rtt = (exchange.came_back - exchange.sent) - there;
  if (there < Duration(0) || rtt < Duration(0)) return std::nullopt;
  // Halfway between the two one-way differences: off by at most half the round trip.
  const Duration out = exchange.received - exchange.sent.time_since_epoch();
  const Duration back = exchange.answered - exchange.came_back.time_since_epoch();
  return Point{exchange.sent + (exchange.came_back - exchange.sent) / 2, back + (out - back) / 2,
               rtt};
}

bool ClockOffset::agrees(const ClockExchange& exchange, const Estimate& estimate) noexcept {
  const auto point = proof(exchange);
  return point && agrees(*point, estimate);
}

bool ClockOffset::agrees(const Point& point, const Estimate& estimate) noexcept {
  return std::chrono::abs(point.offset - estimate.offset) <= point.rtt / 2 + estimate.bound;
}

void ClockOffset::add(const ClockExchange& exchange) noexcept {
  const auto proven = proof(exchange);
  if (!proven) return;
  const Point& point = *proven;
  const auto estimate = at(point.when);
  if (estimate && !agrees(point, *estimate)) {
    if (++contradictions_ < kContradictions) return;
    count_ = 0;
    ++steps_;
  }
  contradictions_ = 0;
  keep(point);
  fit();
}

void ClockOffset::keep(const Point& point) noexcept {
  if (count_ > 0 && point.when - interval_began_ < kInterval) {
    if (point.rtt <= points_[count_ - 1].rtt) points_[count_ - 1] = point;
    return;
  }
  if (count_ == kIntervals) {
    std::move(points_.begin() + 1, points_.end(), points_.begin());
    --count_;
  }
  points_[count_++] = point;
  interval_began_ = point.when;
}

void ClockOffset::fit() noexcept {
  base_ = points_[count_ - 1].when;
  Duration least = points_[0].rtt;
  for (std::size_t i = 0; i < count_; ++i) least = std::min(least, points_[i].rtt);
  // A point's error is what its round trip has above the least: queues, mostly on one way. 10 us
  // more, because time stamps of programs are no better.
  double sum = 0.0, sum_t = 0.0, sum_o = 0.0;
  std::array<double, kIntervals> weight{};
  const double origin = ns(points_[count_ - 1].offset);
  for (std::size_t i = 0; i < count_; ++i) {
    const double sigma = ns(points_[i].rtt - least) / 2 + 10e3;
    weight[i] = 1.0 / (sigma * sigma);
    sum += weight[i];
    sum_t += weight[i] * ns(points_[i].when - base_);
    sum_o += weight[i] * (ns(points_[i].offset) - origin);
  }
  const double mean_t = sum_t / sum, mean_o = sum_o / sum;
  double square = 0.0, product = 0.0;
  for (std::size_t i = 0; i < count_; ++i) {
    const double t = ns(points_[i].when - base_) - mean_t;
    square += weight[i] * t * t;
    product += weight[i] * t * (ns(points_[i].offset) - origin - mean_o);
  }
  // Over less than four intervals a slope is mostly noise.
  const bool long_enough = points_[count_ - 1].when - points_[0].when >= 4 * kInterval;
  drift_ = long_enough && square > 0.0 ? std::clamp(product / square, -kLargestDrift, kLargestDrift)
                                       : 0.0;
  offset_ns_ = origin + mean_o - drift_ * mean_t;
}

std::optional<ClockOffset::Estimate> ClockOffset::at(TimePoint now) const noexcept {
  if (count_ == 0) return std::nullopt;
  const Duration offset = from_ns(offset_ns_ + drift_ * ns(now - base_));
  // Each point proves an interval; the tightest that still holds, widened by what may have drifted
  // since, bounds the error of the line.
  Duration bound = Duration::max();
  for (std::size_t i = 0; i < count_; ++i) {
    const Point& point = points_[i];
    bound = std::min(
        bound, std::chrono::abs(offset - point.offset) + point.rtt / 2 + drifted(now - point.when));
  }
  return Estimate{offset, drift_, bound};
}

}  // namespace haptic::wire
