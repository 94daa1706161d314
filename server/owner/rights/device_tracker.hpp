#pragma once
/// Which session says where a device's palm is, and the one door for its poses
/// (proto/README.md#a-session, role tracker). At most one session per device; the place is free
/// again when the session is over, or was silent for the lease time, and its last pose has faded
/// out: force is never led from one tracker's world into the next one's. It knows no thread, as the
/// ingress.
///
/// A pose is used if it is finite, a rotation (a unit quaternion), within the palm's range and
/// newer than the last. Backlog ages as that of proxies (ingress.hpp). A pose that is refused
/// changes nothing: the last good one stays, and ages.

#include <array>
#include <optional>

#include "haptic/core/tick/mailbox.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "server/crossing/outcome.hpp"
#include "server/owner/ingress/ingress.hpp"

namespace haptic::server {

class DeviceTracker {
 public:
  /// How far the norm of an orientation may be off 1: a rounded one is, a wrong one is by more.
  static constexpr double kNormTolerance = 0.01;

  /// `mailbox` must outlive this. `config` has a tracker. `fresh_bound`: the scene's bound on
  /// fresh_end. `silence`: after which the place is free.
  DeviceTracker(core::Mailbox<core::TrackerSnapshot>& mailbox, const core::PipelineConfig& config,
                std::optional<core::Duration> fresh_bound, core::Duration silence);

  /// Takes the place, with the limits of its poses' age. Refused: TRACKER_HELD (kExists, names the
  /// holder), or a rate or limits that are off.
  [[nodiscard]] Outcome<core::StalenessLimits> open(const LeaseRequest& request,
                                                    core::TimePoint now);
  /// Gives it up if it is this session's. Idempotent.
  void close(const SessionId& session_id);

  /// Subnormal numbers become 0.
  Verdict accept(const PoseSample& pose);

  /// Client name of the holder; empty: none.
  [[nodiscard]] ClientName client_name() const;

 private:
  [[nodiscard]] Verdict check(const PoseSample& pose) const;

  core::Mailbox<core::TrackerSnapshot>& mailbox_;
  const core::StalenessLimits scene_;
  const std::optional<core::Duration> fresh_bound_;
  const core::Duration silence_;
  std::array<double, 3> lower_{}, upper_{};  ///< of the position, m

  SessionId session_id_{};  ///< empty: no session has the place
  ClientName client_name_{};
  core::TimePoint heard_{};  ///< newest accepted pose, or the opening
  std::uint64_t seq_{0};     ///< newest accepted of this session
  BacklogRule backlog_{};
  core::TrackerSnapshot newest_{};
};

}  // namespace haptic::server
