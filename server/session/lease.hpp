#pragma once
/// The lease: who may stream proxies to a device, since when, and until when
/// (proto/README.md#a-session).

#include <cstdint>
#include <optional>
#include <string>

#include "haptic/core/safety/staleness.hpp"
#include "haptic/core/time.hpp"
#include "server/crossing/priority.hpp"

namespace haptic::server {

/// A lease that was granted.
struct Lease {
  std::uint32_t epoch{0};
  core::StalenessLimits staleness{};  ///< in force
  std::uint32_t grant{0};             ///< what the loop knows it by: a resumed lease keeps it
  bool resumed{false};
  std::uint64_t newest_seq{0};  ///< accepted so far
  std::string taken_from{};     ///< client name of the preempted holder; empty: it was free
};

struct LeaseRequest {
  std::string session_id{};
  std::string client_name{};
  double nominal_rate_hz{0.0};
  Priority priority{Priority::kPrimary};
  bool resumable{false};
  std::string resume{};  ///< session whose lease is to go on; empty: none
  std::optional<core::Duration> fresh_end{};
  std::optional<core::Duration> hold_end{};
  std::optional<core::Duration> fade_end{};
};

/// Exactly one holder or none, and an epoch that only rises: by one with every grant and with every
/// resume. The clock of a lease runs from its last accepted sample, or from its opening before the
/// first one; at `timeout` it has expired. A resume starts the clock anew only where a sample came
/// since it was started: data is the sign of life, coming back is none. A lease whose session lost
/// its stream is detached: it is held against time only, not against others who want it.
class LeaseBook {
 public:
  explicit LeaseBook(core::Duration timeout) : timeout_(timeout) {}

  [[nodiscard]] bool held() const noexcept { return held_; }
  [[nodiscard]] bool held_by(const std::string& session_id) const noexcept {
    return held_ && session_id == session_id_;
  }
  [[nodiscard]] const std::string& session_id() const noexcept { return session_id_; }
  [[nodiscard]] const std::string& client_name() const noexcept { return client_name_; }
  [[nodiscard]] Priority priority() const noexcept { return priority_; }
  [[nodiscard]] bool detached() const noexcept { return held_ && detached_; }
  [[nodiscard]] bool resumable() const noexcept { return held_ && resumable_; }
  [[nodiscard]] std::uint32_t epoch() const noexcept { return grants_ + resumes_; }
  /// Grants so far: what the loop knows a lease by, so that a resume changes nothing there.
  [[nodiscard]] std::uint32_t grants() const noexcept { return grants_; }
  [[nodiscard]] std::uint32_t resumes() const noexcept { return resumes_; }
  [[nodiscard]] core::Duration timeout() const noexcept { return timeout_; }

  /// A new lease under a new epoch, which is the answer. Precondition: !held().
  std::uint32_t grant(const LeaseRequest& request, core::TimePoint now);
  void end() noexcept;
  /// Its session lost the stream. Only where it is resumable.
  void detach() noexcept { detached_ = true; }
  /// The lease goes on for `request`, under a new epoch; `last_accepted` as for expired().
  /// Precondition: resumable().
  std::uint32_t resume(const LeaseRequest& request, core::TimePoint now,
                       core::TimePoint last_accepted);
  /// A newcomer of `priority` may have it: it is free, of lower priority, or detached and of the
  /// same.
  [[nodiscard]] bool yields_to(Priority priority) const noexcept;
  /// The clock runs from `now` on.
  void restart_clock(core::TimePoint now) noexcept { opened_ = now; }
  /// `last_accepted`: of the ingress, under this lease; older than the opening before the first
  /// one.
  [[nodiscard]] bool expired(core::TimePoint now, core::TimePoint last_accepted) const noexcept;

 private:
  core::Duration timeout_;
  bool held_{false};
  bool detached_{false};
  bool resumable_{false};
  Priority priority_{Priority::kPrimary};
  std::uint32_t grants_{0};
  std::uint32_t resumes_{0};
  core::TimePoint opened_{};
  std::string session_id_{};
  std::string client_name_{};
};

}  // namespace haptic::server
