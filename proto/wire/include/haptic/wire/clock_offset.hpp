#pragma once
/// Offset and drift of the other end's steady clock against this end's, from exchanges of four time
/// stamps (as NTP's, RFC 5905 8): the exchange of least round trip per interval, and a line through
/// those.
///
/// An exchange proves its offset to within half its round trip, whatever the queues did; the least
/// round trip of many proves it best. The line through such points gives the drift, so that the
/// offset still holds between exchanges. A clock that was stepped contradicts the proof: three
/// exchanges in a row that exclude the line start the estimate again.

#include <array>
#include <cstddef>
#include <optional>

#include "haptic/wire/time.hpp"

namespace haptic::wire {

/// One question and its answer. Points of this end's clock, and readings of the other end's.
struct ClockExchange {
  TimePoint sent{};       ///< this end's clock: question left
  Duration received{0};   ///< theirs, question came
  Duration answered{0};   ///< theirs, answer left
  TimePoint came_back{};  ///< this end's clock
};

/// Not thread-safe.
class ClockOffset {
 public:
  static constexpr Duration kInterval{std::chrono::milliseconds(500)};
  static constexpr std::size_t kIntervals = 32;
  /// Upper bound of the drift between two quartz clocks: how far an old point may be off by now.
  static constexpr double kLargestDrift = 500e-6;
  static constexpr int kContradictions = 3;

  struct Estimate {
    Duration offset{0};  ///< their clock minus this end's, now
    double drift{0.0};   ///< theirs runs faster by this share
    Duration bound{0};   ///< the true offset lies within offset +- bound while drifts are plausible
  };

  /// Exchanges that cannot be (negative round trip, readings beyond 146 years) are ignored.
  void add(const ClockExchange& exchange) noexcept;
  /// None before the first exchange.
  [[nodiscard]] std::optional<Estimate> at(TimePoint now) const noexcept;

  /// `exchange` may be true together with `estimate`: what it proves by itself does not exclude
  /// that. A message that was under way for long agrees; one of a clock that was stepped does not.
  [[nodiscard]] static bool agrees(const ClockExchange& exchange,
                                   const Estimate& estimate) noexcept;

  /// How often the estimate started again.
  [[nodiscard]] unsigned steps() const noexcept { return steps_; }

 private:
  struct Point {
    TimePoint when{};
    Duration offset{0};
    Duration rtt{0};
  };
  /// The point that an exchange proves; none if it cannot be.
  [[nodiscard]] static std::optional<Point> proof(const ClockExchange& exchange) noexcept;
  [[nodiscard]] static bool agrees(const Point& point, const Estimate& estimate) noexcept;
  void keep(const Point& point) noexcept;
  void fit() noexcept;

  std::array<Point, kIntervals> points_{};  ///< best of each interval, oldest first
  std::size_t count_{0};
  TimePoint interval_began_{};
  int contradictions_{0};
  unsigned steps_{0};
  // The line: offset_ at base_, and its slope.
  TimePoint base_{};
  double offset_ns_{0.0};
  double drift_{0.0};
};

}  // namespace haptic::wire
