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
struct LeaseBook {
  core::Duration timeout{0};
  bool has_holder{false};
  bool detached{false};   ///< its session lost the stream
  bool resumable{false};  ///< of the holder's
  Priority priority{Priority::kPrimary};
  std::uint32_t tenure{0};  ///< the number by which the loop knows a lease
  std::uint32_t resumes{0};
  core::TimePoint opened{};  ///< what its clock runs from before the first sample
  SessionId session_id{};    ///< of the holder; empty: none
  ClientName client_name{};

  [[nodiscard]] std::uint32_t epoch() const noexcept { return tenure + resumes; }
  [[nodiscard]] bool held_by(const SessionId& id) const noexcept {
    return has_holder && id == session_id;
  }
  /// A new lease under a new epoch. Precondition: !has_holder.
  void grant(const LeaseRequest& request, core::TimePoint now);
  void end() noexcept;
  /// The lease goes on for `request`, under a new epoch, which is the answer; `last_accepted` as
  /// for expired(). Precondition: resumable.
  std::uint32_t resume(const LeaseRequest& request, core::TimePoint now,
                       core::TimePoint last_accepted);
  /// A newcomer of `wanted` may have it: it is free, of lower priority, or detached and of the
  /// same.
  [[nodiscard]] bool yields_to(Priority wanted) const noexcept;
  /// `last_accepted`: of the ingress, under this lease; older than the opening before the first
  /// one.
  [[nodiscard]] bool expired(core::TimePoint now, core::TimePoint last_accepted) const noexcept;
};

}  // namespace haptic::server
