#pragma once
/// The lease: which session may stream proxies to a device, since when, and until when
/// (proto/README.md#a-session).

#include <cstdint>

#include "server/crossing/crossing.hpp"

namespace haptic::server {

/// Exactly one holder or none, and an epoch that only rises: by one with every grant and with every
/// resume. The clock of a lease runs from its last accepted sample, or from its opening before the
/// first one; at `timeout` it has expired. A resume restarts the clock only if a sample came since
/// it was last started: data is the sign of life, coming back is none. A lease whose session lost
/// its stream is detached: it is held against time only, not against other sessions that want it.
class LeaseBook {
 public:
  explicit LeaseBook(core::Duration timeout) : timeout_(timeout) {}

  [[nodiscard]] bool has_holder() const noexcept { return held_; }
  [[nodiscard]] bool held_by(const SessionId& session_id) const noexcept {
    return held_ && session_id == session_id_;
  }
  [[nodiscard]] const SessionId& session_id() const noexcept { return session_id_; }
  [[nodiscard]] const ClientName& client_name() const noexcept { return client_name_; }
  [[nodiscard]] Priority priority() const noexcept { return priority_; }
  [[nodiscard]] bool detached() const noexcept { return held_ && detached_; }
  [[nodiscard]] bool resumable() const noexcept { return held_ && resumable_; }
  [[nodiscard]] std::uint32_t epoch() const noexcept { return tenure_ + resumes_; }
  /// The number by which the loop knows a lease: a resume does not change it.
  [[nodiscard]] std::uint32_t tenure() const noexcept { return tenure_; }
  [[nodiscard]] std::uint32_t resumes() const noexcept { return resumes_; }

  /// A new lease under a new epoch. Precondition: !has_holder().
  void grant(const LeaseRequest& request, core::TimePoint now);
  void end() noexcept;
  /// Its session lost the stream. Precondition: resumable().
  void detach() noexcept { detached_ = true; }
  /// The lease goes on for `request`, under a new epoch, which is the answer; `last_accepted` as
  /// for expired(). Precondition: resumable().
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
  void take(const LeaseRequest& request) noexcept;

  core::Duration timeout_;
  bool held_{false};
  bool detached_{false};
  bool resumable_{false};
  Priority priority_{Priority::kPrimary};
  std::uint32_t tenure_{0};
  std::uint32_t resumes_{0};
  core::TimePoint opened_{};
  SessionId session_id_{};
  ClientName client_name_{};
};

}  // namespace haptic::server
