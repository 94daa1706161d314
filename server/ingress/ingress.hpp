#pragma once
/// The one door for proxy samples, whatever carried them: lease epoch, size, finite, in bounds,
/// newer than the last; then the mailbox. Takes a mutex; the loop never does.
///
/// Back-log. After a stall a reliable transport delivers at once what it had kept back, and the
/// first samples of such a burst look like a stream that just came back to life. A sample is
/// back-log where its burst exceeds twice the nominal rate by more than the tolerance. It becomes
/// the newest (the server must not render where the proxy was even longer ago), but it is not
/// young: `born` goes back to what it was before the burst, so the age runs on as if the burst had
/// not come. Normal again is the first sample that comes half a nominal period or more after the
/// one before it: the pipe had run dry. Where that pause was a whole period, what came before it
/// had been the newest there was, and a burst that follows falls back to its arrival: jitter that
/// clumps a healthy stream again and again does not add up to a lost one.
///
/// Tolerance: half a period - two samples at once, which is one sample late by a period - or 5 ms,
/// whichever is longer. 5 ms is the shortest fresh_end (proto/README.md#staleness-and-gain):
/// clumping within it cannot make a sample look fresh that is not, and a 1 kHz stream clumps by
/// that much on any busy host.

#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "haptic/core/tick/mailbox.hpp"
#include "haptic/core/tick/tick_input.hpp"

namespace haptic::server {

/// A plane as it came off the wire.
struct PlaneCandidate {
  const double* normal{nullptr};
  int normal_size{0};
  double offset{0.0};
};

/// Which way a sample came.
enum class Carrier : std::uint8_t { kNone = 0, kGrpc = 1, kUdp = 2 };

/// A sample as it came off the wire, before anything was checked but its syntax.
struct ProxyCandidate {
  std::uint32_t epoch{0};
  std::uint64_t seq{0};
  core::ProxyMode mode{core::ProxyMode::kNone};  ///< kNone: the wire named no known mode
  core::Duration valid_for{0};
  const double* position{nullptr};
  int position_size{0};
  std::array<PlaneCandidate, core::kMaxPlanes> planes{};
  int plane_count{
      0};  ///< as on the wire: may be more than kMaxPlanes, which are then not in `planes`
  Carrier carrier{Carrier::kGrpc};
  /// When it left its source at the latest, by a synchronised clock: its age counts from there
  /// where that is before its arrival (proto/README.md#staleness-and-gain).
  std::optional<core::TimePoint> left{};
};

enum class IngressVerdict : std::uint8_t {
  kAccepted,
  kBacklog,  ///< accepted as the newest, but not as fresh (faster than twice the nominal rate)
  kOldSequence,
  kOldEpoch,  ///< of a lease that is no more
  kWrongSize,
  kNotFinite,
  kOutOfBounds,  ///< |position| > 1000 (m or rad)
  kUnknownMode,
  kBadPlane,  ///< too many, of a wrong size, not finite, too large, or without a direction
};

struct IngressCounters {
  std::uint64_t accepted{0};
  std::uint64_t backlog{0};
  std::uint64_t old_sequence{0};
  std::uint64_t old_epoch{0};
  std::uint64_t wrong_size{0};
  std::uint64_t not_finite{0};
  std::uint64_t out_of_bounds{0};
  std::uint64_t unknown_mode{0};
  std::uint64_t bad_plane{0};

  IngressCounters& operator+=(const IngressCounters& other) noexcept;
};

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

 private:
  core::Duration interval_{0};  ///< half a nominal period
  core::Duration tolerance_{0};
  bool first_{true};
  bool backlog_{false};
  core::TimePoint last_arrival_{};
  core::TimePoint born_{};          ///< of the newest sample
  core::TimePoint before_burst_{};  ///< what born_ falls back to
  core::TimePoint due_{};           ///< where twice the nominal rate would put the next arrival
};

class Ingress {
 public:
  static constexpr double kLargestCoordinate = 1000.0;
  static constexpr double kLargestNormal = 1e6;  ///< of a component
  static constexpr double kLargestOffset = 1e9;

  /// `mailbox` must outlive the ingress; `n_x` is the size of the virtual configuration.
  Ingress(core::Mailbox<core::ProxySnapshot>& mailbox, int n_x);

  /// A new lease: samples of older epochs are refused from now on; sequence, counters and the
  /// stream's health start anew. `grant`: what the loop knows the lease by; 0: its epoch.
  void begin_lease(std::uint32_t epoch, double nominal_rate_hz, core::Duration hold_end,
                   std::uint32_t grant = 0);
  /// The lease goes on under another epoch: samples of the former are refused, all else stays.
  void renew_lease(std::uint32_t epoch);
  /// No lease: everything is refused.
  void end_lease();
  /// Why the newest sample of this lease that was refused was; empty where none was.
  [[nodiscard]] std::string last_refusal() const;

  /// Any thread. Subnormal coordinates become 0. `why`, where given, gets a sentence that names
  /// field, value and what is allowed for every verdict but kAccepted and kBacklog.
  IngressVerdict accept(const ProxyCandidate& candidate, core::TimePoint arrival,
                        std::string* why = nullptr);

  /// Since the current lease began.
  [[nodiscard]] IngressCounters counters() const;
  /// Since the server started.
  [[nodiscard]] IngressCounters totals() const;
  /// Local arrival of the newest accepted sample (back-log included: it shows that the client
  /// lives) under the current lease; TimePoint{} before the first one.
  [[nodiscard]] core::TimePoint last_accepted() const;
  /// Of the newest accepted sample under the current lease; kNone before the first one. Any thread.
  [[nodiscard]] Carrier carrier() const noexcept {
    return carrier_.load(std::memory_order_relaxed);
  }
  /// Who carried the sample that a tick used, named by its number and what its age counts from;
  /// kNone where it is not among the last 256.
  [[nodiscard]] Carrier carrier_of(std::uint64_t seq, core::TimePoint born) const noexcept;
  /// Newest accepted under the current lease; 0 before the first.
  [[nodiscard]] std::uint64_t newest_seq() const;

 private:
  [[nodiscard]] IngressVerdict check(const ProxyCandidate& candidate, std::string* why);
  /// What is wrong with the planes of a sample; empty: nothing.
  [[nodiscard]] std::string wrong_plane(const ProxyCandidate& candidate) const;
  void store(const ProxyCandidate& candidate, BacklogRule::Answer age, core::TimePoint arrival);

  mutable std::mutex mutex_;
  std::string last_refusal_{};
  core::Mailbox<core::ProxySnapshot>& mailbox_;
  const int n_x_;
  core::ProxySnapshot newest_{};
  IngressCounters counters_{};
  IngressCounters before_{};  ///< under the leases before this one
  BacklogRule backlog_{};
  core::TimePoint last_arrival_{};
  struct Carried {
    std::uint64_t seq{0};
    core::TimePoint born{};
    Carrier carrier{Carrier::kNone};
  };
  std::array<Carried, 256> carried_{};  ///< by seq, modulo
  std::atomic<Carrier> carrier_{Carrier::kNone};
  core::Duration hold_end_{0};
  std::uint32_t epoch_{0};
  bool open_{false};
};

}  // namespace haptic::server
