#pragma once
/// The one door for proxy samples, whatever carried them: size, finite, in bounds, lease epoch, newer
/// than the last; then the mailbox. Takes a mutex; the loop never does.

#include <cstdint>
#include <mutex>
#include <string>

#include "haptic/core/tick/mailbox.hpp"
#include "haptic/core/tick/tick_input.hpp"

namespace haptic::server {

/// A sample as it came off the wire, before anything was checked but its syntax.
struct ProxyCandidate {
  std::uint32_t epoch{0};
  std::uint64_t seq{0};
  core::ProxyMode mode{core::ProxyMode::kNone};  ///< kNone: the wire named no known mode
  core::Duration valid_for{0};
  const double* position{nullptr};
  int position_size{0};
};

enum class IngressVerdict : std::uint8_t {
  kAccepted,
  kBacklog,          ///< accepted as the newest, but not as fresh (faster than twice the nominal rate)
  kOldSequence,
  kOldEpoch,         ///< of a lease that is no more
  kWrongSize,
  kNotFinite,
  kOutOfBounds,      ///< |position| > 1000 (m or rad)
  kUnknownMode,
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
};

class Ingress {
 public:
  static constexpr double kLargestCoordinate = 1000.0;

  /// `mailbox` must outlive the ingress; `n_x` is the size of the virtual configuration.
  Ingress(core::Mailbox<core::ProxySnapshot>& mailbox, int n_x);

  /// A new lease: samples of older epochs are refused from now on, sequence starts anew.
  void begin_lease(std::uint32_t epoch, double nominal_rate_hz, core::Duration hold_end);
  /// No lease: everything is refused.
  void end_lease();

  /// Any thread. Subnormal coordinates become 0. `why`, where given, gets a sentence that names field, value
  /// and what is allowed for every verdict but kAccepted and kBacklog.
  IngressVerdict accept(const ProxyCandidate& candidate, core::TimePoint arrival,
                        std::string* why = nullptr);

  [[nodiscard]] IngressCounters counters() const;
  /// Local arrival of the newest accepted sample under the current lease; the lease's begin before
  /// the first one is the caller's to know.
  [[nodiscard]] core::TimePoint last_accepted() const;

 private:
  mutable std::mutex mutex_;
  core::Mailbox<core::ProxySnapshot>& mailbox_;
  const int n_x_;
  core::ProxySnapshot newest_{};
  IngressCounters counters_{};
  core::TimePoint last_arrival_{};
  core::Duration nominal_period_{0};
  core::Duration hold_end_{0};
  std::uint32_t epoch_{0};
};

}  // namespace haptic::server
