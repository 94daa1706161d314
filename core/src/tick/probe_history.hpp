#pragma once
/// The haptic probes of the last ticks: what a simulation saw when it computed its sample.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "haptic/core/time.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

class ProbeHistory {
 public:
  /// At 1 kHz longer than any round trip, period and silence after which a sample is still felt.
  static constexpr std::uint64_t kTicks = 1024;

  explicit ProbeHistory(int n_x)
      : values_(kTicks * static_cast<std::size_t>(n_x)), times_(kTicks) {}

  /// x_probe (n_x) of `tick`, which rises by one from call to call.
  void push(std::uint64_t tick, TimePoint now, const VecX& x_probe) noexcept {
    newest_ = tick;
    if (oldest_ == 0) oldest_ = tick;
    times_[tick % kTicks] = now;
    std::copy_n(x_probe.data(), x_probe.size(), values_.begin() + first_of(tick, x_probe.size()));
  }
  /// Writes x_probe (n_x) of `tick`. False: it is not known, or not any more.
  [[nodiscard]] bool find(std::uint64_t tick, VecX& x_probe) const noexcept {
    if (tick < oldest_ || tick > newest_ || newest_ - tick >= kTicks || newest_ == 0) return false;
    const auto n_x = static_cast<std::ptrdiff_t>(values_.size() / kTicks);
    x_probe.resize(n_x);
    std::copy_n(values_.begin() + first_of(tick, n_x), n_x, x_probe.data());
    return true;
  }

  /// Time of `tick`, whose x_probe is known.
  [[nodiscard]] TimePoint time(std::uint64_t tick) const noexcept { return times_[tick % kTicks]; }

 private:
  [[nodiscard]] static std::ptrdiff_t first_of(std::uint64_t tick, std::ptrdiff_t n_x) noexcept {
    return static_cast<std::ptrdiff_t>(tick % kTicks) * n_x;
  }

  std::vector<double> values_;
  std::vector<TimePoint> times_;
  std::uint64_t oldest_{0}, newest_{0};
};

}  // namespace haptic::core
