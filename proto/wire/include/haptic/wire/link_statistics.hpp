#pragma once
/// Figures of one direction of a link, judged by the packet numbers that came
/// (proto/README.md#a-session, GetLinkStats).

#include <array>
#include <cstdint>
#include <optional>

#include "haptic/wire/datagram.hpp"
#include "haptic/wire/time.hpp"

namespace haptic::wire {

struct LinkCounters {
  std::uint64_t received{0};  ///< genuine datagrams
  std::uint64_t bytes{0};     ///< of those
  /// Numbers below the newest that did not come so far; falls again if they come late.
  std::uint64_t lost{0};
  std::uint64_t reordered{0};                         ///< came after a higher number
  std::array<std::uint64_t, kRejections> rejected{};  ///< by Rejection
  Duration longest_gap{0};                            ///< between two arrivals
  Duration jitter{0};  ///< smoothed difference of transit times, RFC 3550 6.4.1

  [[nodiscard]] std::uint64_t rejections(Rejection why) const noexcept {
    return rejected[static_cast<std::size_t>(why)];
  }
  [[nodiscard]] std::uint64_t duplicate() const noexcept {
    return rejections(Rejection::kDuplicate);
  }
  [[nodiscard]] std::uint64_t late() const noexcept { return rejections(Rejection::kTooOld); }
};

/// Not thread-safe.
class LinkStatistics {
 public:
  /// A datagram passed every check of the channel.
  void accepted(std::uint64_t packet_number, std::size_t bytes, TimePoint arrival) noexcept;
  void rejected(Rejection why) noexcept { ++counters_.rejected[static_cast<std::size_t>(why)]; }
  /// Its sender's clock at sending: for jitter. Clocks need no common origin.
  void timed(Duration sender_time, TimePoint arrival) noexcept;
  /// Packet numbers start at 1 again (rekey); totals stay.
  void renumber() noexcept;

  [[nodiscard]] const LinkCounters& counters() const noexcept { return counters_; }
  /// Under the numbering in force: what a PATH_RESPONSE reports.
  [[nodiscard]] std::uint64_t packets() const noexcept { return packets_; }
  [[nodiscard]] std::uint64_t newest() const noexcept { return newest_; }

 private:
  LinkCounters counters_{};
  std::uint64_t packets_{0};
  std::uint64_t newest_{0};
  std::uint64_t lost_before_{0};  ///< under former numberings
  std::optional<TimePoint> last_arrival_{};
  std::optional<Duration> transit_{};
};

/// Round trips: smoothed and their variation as RFC 6298, and the least of all.
class RoundTrip {
 public:
  void add(Duration rtt) noexcept;
  [[nodiscard]] bool known() const noexcept { return known_; }
  [[nodiscard]] Duration smoothed() const noexcept { return smoothed_; }
  [[nodiscard]] Duration variation() const noexcept { return variation_; }
  [[nodiscard]] Duration least() const noexcept { return least_; }

 private:
  bool known_{false};
  Duration smoothed_{0}, variation_{0}, least_{0};
};

/// The share of our datagrams that did not reach the other end, by what the other end reports
/// (PathResponse), over the last second or a little more.
class LossReport {
 public:
  static constexpr Duration kOver{std::chrono::seconds(1)};
  /// Fewer packets than this say nothing about a share.
  static constexpr std::uint64_t kLeastPackets = 10;

  /// Reports that came out of order are ignored.
  void add(std::uint64_t packets, std::uint64_t newest, TimePoint arrival) noexcept;
  /// None before a second's worth is known.
  [[nodiscard]] std::optional<double> share() const noexcept;
  /// New keys, new numbers, or a new path.
  void restart() noexcept { *this = {}; }

 private:
  struct Report {
    std::uint64_t packets{0}, newest{0};
    TimePoint arrival{};
  };
  static constexpr std::size_t kKept = 8;
  static constexpr Duration kApart{kOver / static_cast<int>(kKept - 1)};
  std::array<Report, kKept> kept_{};  ///< kApart between two, oldest first
  std::size_t count_{0};
  Report newest_{};
};

}  // namespace haptic::wire
