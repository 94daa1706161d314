#pragma once
/// Figures of one session's links, and how old a sample was when it arrived
/// (proto/README.md#a-session and proto/README.md#staleness-and-gain).
///
/// Every sample brings a whole exchange of time stamps with it: the state it was computed from left
/// at a tick of the server, the client received it `hold` before its source time, and the sample
/// arrived. So round trip and clock offset are known on either carrier, without a message of their
/// own.

#include <array>
#include <cstdint>
#include <optional>

#include "haptic/core/time.hpp"
#include "haptic/wire/clock_offset.hpp"
#include "haptic/wire/link_statistics.hpp"
#include "server/base/rolling_histogram.hpp"
#include "server/crossing/crossing.hpp"
#include "server/front/net/wire_time.hpp"

namespace haptic::server {

/// A sample's word about its way.
struct SampleStamp {
  Carrier carrier{Carrier::kGrpc};
  std::size_t bytes{0};
  std::int64_t source_time_ns{0};  ///< the client's steady clock; 0: not given
  std::uint64_t state_used{0};     ///< tick of the state it was computed from; 0: none
  core::Duration hold{0};          ///< the client held that state
  core::TimePoint arrival{};
};

/// Stable names of verdicts: "OLD_SEQUENCE".
[[nodiscard]] const char* name(IngressVerdict verdict) noexcept;

/// Samples that came by one carrier, and states that went by it.
struct CarrierFigures {
  std::uint64_t samples{0}, sample_bytes{0};
  std::array<std::uint64_t, kIngressVerdicts> rejected{};  ///< by IngressVerdict
  core::Duration longest_gap{0};                           ///< between two samples
  core::Duration jitter{0};                                ///< RFC 3550 6.4.1; 0: not known
  wire::RoundTrip round_trip{};
  std::uint64_t states{0};
};

/// Not thread-safe, but for age_at_use().
class LinkWatch {
 public:
  void state_sent(std::uint64_t tick, core::TimePoint now, Carrier carrier) noexcept;

  /// A sample came. The answer is when it left its source, by the tighter of this estimate of the
  /// client's clock and `other`, the path's; never later than its arrival. Absent if the client's
  /// clock is not known, or if the sample's own exchange does not agree with the estimate: a clock
  /// that was stepped must not make a sample old.
  [[nodiscard]] std::optional<Departure> came(
      const SampleStamp& stamp, const std::optional<wire::ClockOffset::Estimate>& other) noexcept;
  void judged(Carrier carrier, IngressVerdict verdict) noexcept;
  /// A tick used a sample of this session at that age. One thread.
  void used(core::TimePoint now, core::Duration age) noexcept { ages_.add(now, age); }

  [[nodiscard]] const CarrierFigures& figures(Carrier carrier) const noexcept;
  [[nodiscard]] const wire::ClockOffset& clock() const noexcept { return clock_; }
  [[nodiscard]] Percentiles age_at_use() const noexcept { return ages_.read(); }
  /// Samples that left more than a tick before their arrival says.
  [[nodiscard]] std::uint64_t aged() const noexcept { return aged_; }

 private:
  struct Sent {
    std::uint64_t tick{0};
    core::TimePoint at{};
  };
  [[nodiscard]] CarrierFigures& of(Carrier carrier) noexcept;
  [[nodiscard]] std::optional<wire::ClockExchange> exchange(const SampleStamp& stamp,
                                                            CarrierFigures& figures) noexcept;

  struct Arrival {
    std::optional<core::TimePoint> last{};
    std::optional<core::Duration> transit{};
  };
  std::array<Sent, 2048> sent_{};  ///< by tick, modulo: round trips of up to 2 s at 1 kHz
  std::array<CarrierFigures, 2> figures_{};
  std::array<Arrival, 2> arrivals_{};
  wire::ClockOffset clock_{};
  RollingHistogram ages_{};
  std::uint64_t aged_{0};
};

}  // namespace haptic::server
