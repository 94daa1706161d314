#pragma once
/// The one door for samples of the proxy, whatever carried them. A sample must be of the lease's
/// epoch, of the right size, finite, within bounds and newer than the last; then it goes to the
/// loop's mailbox. It knows no thread: its caller takes turns.
///
/// Backlog. After a stall a reliable transport delivers at once what it had kept back, and the
/// first samples of such a burst look like a stream that came back to life. A sample is backlog if
/// its burst exceeds twice the nominal rate by more than the tolerance. It becomes the newest (the
/// server must not render an even older proxy), but it is not young: `born` goes
/// back to what it was before the burst, so that the age runs on as if the burst had not come. The
/// first sample that comes half a nominal period or more after the one before it is normal again:
/// the pipe had run dry. If that pause was a whole period, the sample before it had been the newest
/// there was, and a burst that follows falls back to its arrival, so that jitter that clumps a
/// healthy stream again and again does not add up to a lost one.
///
/// Tolerance: half a period (two samples at once: one of them late by a period), or 5 ms if that is
/// longer. 5 ms is the shortest fresh_end (proto/README.md#staleness-and-gain): clumping within it
/// cannot make a sample look fresh that is not, and a 1 kHz stream clumps by that much on a busy
/// host.

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "haptic/core/tick/mailbox.hpp"
#include "haptic/core/tick/tick_input.hpp"
#include "server/crossing/crossing.hpp"

namespace haptic::server {

/// 0 for a number below the normal range, which would cost a hundred times a normal one in every
/// product of the loop.
[[nodiscard]] double flushed(double value) noexcept;

/// Tells back-log from a stream that keeps time. Not thread-safe.
class BacklogRule {
 public:
  static constexpr core::Duration kShortestFreshEnd{std::chrono::milliseconds(5)};

  BacklogRule() = default;
  explicit BacklogRule(core::Duration nominal_period);

  struct Answer {
    bool backlog{false};
    core::TimePoint born{};  ///< what the sample's age counts from
  };
  [[nodiscard]] Answer step(core::TimePoint arrival) noexcept;
  /// The rate of the last half second with samples in it, if that was too fast.
  [[nodiscard]] core::StreamRate too_fast() const noexcept;

 private:
  core::Duration interval_{0};  ///< half a nominal period
  core::Duration tolerance_{0};
  bool first_{true};
  bool backlog_{false};
  core::TimePoint last_arrival_{};
  core::TimePoint born_{};          ///< of the newest sample
  core::TimePoint before_burst_{};  ///< what born_ falls back to
  core::TimePoint due_{};           ///< next arrival at twice the nominal rate
  core::TimePoint counted_from_{};
  int count_{0};
  double comes_hz_{0.0};
};

class Ingress {
 public:
  static constexpr double kLargestCoordinate = 1000.0;
  static constexpr double kLargestNormal = 1e6;  ///< of a component
  static constexpr double kLargestCurvature = 1e9;

  /// `mailbox` must outlive the ingress; `n_x` is the size of the virtual configuration.
  Ingress(core::Mailbox<core::ProxySnapshot>& mailbox, int n_x);

  /// A new lease: samples of older epochs are refused from now on; sequence and the stream's
  /// health start again. `tenure`: what the loop knows the lease by; 0: its epoch.
  void begin_lease(std::uint32_t epoch, double nominal_rate_hz, core::Duration hold_end,
                   std::uint32_t tenure = 0);
  /// The lease goes on under another epoch: samples of the former are refused, all else stays.
  void renew_lease(std::uint32_t epoch);
  /// No lease: everything is refused.
  void end_lease();
  /// Why the newest sample of this lease was refused; empty if it was not.
  [[nodiscard]] std::string_view last_refusal() const noexcept { return last_refusal_; }

  /// Subnormal coordinates become 0. Allocates nothing.
  Verdict accept(const ProxySample& sample);

  /// Since the server started.
  [[nodiscard]] const IngressCounters& counters() const noexcept { return counters_; }
  /// Local arrival of the newest accepted sample (backlog included: it shows that the client
  /// lives) under the current lease; TimePoint{} before the first one.
  [[nodiscard]] core::TimePoint last_accepted() const noexcept { return last_arrival_; }
  /// Carrier of the newest accepted sample under the current lease; kNone before the first one.
  [[nodiscard]] Carrier carrier() const noexcept { return carrier_; }
  /// Carrier of the sample that a tick used, named by its number and by what its age counts from;
  /// kNone if it is not among the last 256.
  [[nodiscard]] Carrier carrier_of(std::uint64_t seq, core::TimePoint born) const noexcept;
  /// Newest accepted under the current lease; 0 before the first.
  [[nodiscard]] std::uint64_t newest_seq() const noexcept { return newest_.seq; }

 private:
  [[nodiscard]] Verdict check(const ProxySample& sample) const;
  /// Absent: nothing is wrong. (To clear the words of a Verdict for each plane takes time.)
  using Refused = std::optional<Verdict>;
  [[nodiscard]] Refused check_planes(const ProxySample& sample) const;
  [[nodiscard]] Refused check_contact(const ProxySample& sample, std::size_t p) const;
  [[nodiscard]] static Refused check_law(const PlaneSample& plane, std::size_t p);
  [[nodiscard]] static Refused check_object(const PlaneSample& plane, std::size_t p);
  void store(const ProxySample& sample, const BacklogRule::Answer& age);
  /// Makes the snapshot where the mailbox hands it out: with its planes it is large.
  void publish(const ProxySample& sample, core::TimePoint computed);
  void write_planes(const ProxySample& sample, core::ProxySnapshot& next) const;

  decltype(Verdict::why) last_refusal_{};
  core::Mailbox<core::ProxySnapshot>& mailbox_;
  const std::uint32_t n_x_;
  struct Newest {  ///< as in ProxySnapshot
    core::ProxyMode mode{core::ProxyMode::kNone};
    std::uint32_t tenure{0};
    std::uint64_t seq{0};
    core::TimePoint born{}, gapless_since{};
    std::uint64_t gapless_samples{0};
    core::StreamRate too_fast{};
  } newest_{};
  IngressCounters counters_{};
  BacklogRule backlog_{};
  core::TimePoint last_arrival_{};
  struct Carried {
    std::uint64_t seq{0};
    core::TimePoint born{};
    Carrier carrier{Carrier::kNone};
  };
  std::array<Carried, 256> carried_{};  ///< by seq, modulo
  Carrier carrier_{Carrier::kNone};
  core::Duration hold_end_{0};
  std::uint32_t epoch_{0};
  bool open_{false};
};

}  // namespace haptic::server
