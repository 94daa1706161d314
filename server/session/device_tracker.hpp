#pragma once
/// Who says where a device's palm is, and the one door for what they say
/// (proto/README.md#a-session, role tracker). At most one session per device; its place is free
/// again when the session is over, or was silent for the lease time, and its last pose has faded
/// out: force is never led from one tracker's world into the next one's. Takes a mutex; the loop
/// never does.
///
/// A pose is used where it is finite, a rotation (a unit quaternion) within the palm's range, and
/// newer than the last. Back-log is aged as that of proxies (ingress.hpp). What is refused changes
/// nothing: the last good pose stays, and ages.

#include <array>
#include <mutex>
#include <optional>
#include <string>

#include "haptic/core/tick/mailbox.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "server/ingress/ingress.hpp"
#include "server/session/lease.hpp"
#include "server/session/refusal.hpp"

namespace haptic::server {

/// A pose as it came off the wire, before anything was checked but its syntax.
struct PoseCandidate {
  std::uint64_t seq{0};
  core::Duration valid_for{0};
  const double* position{nullptr};  ///< m
  int position_size{0};
  const double* orientation{nullptr};  ///< x, y, z, w
  int orientation_size{0};
};

class DeviceTracker {
 public:
  /// How far the norm of an orientation may be off 1: a rounded one is, a wrong one is by more.
  static constexpr double kNormTolerance = 0.01;

  /// `mailbox` must outlive this. `config` has a tracker. `fresh_bound`: the scene's on fresh_end.
  DeviceTracker(core::Mailbox<core::TrackerSnapshot>& mailbox, const core::PipelineConfig& config,
                std::optional<core::Duration> fresh_bound, core::Duration silence);

  /// Takes the place, with the limits of its poses' age. Refused: TRACKER_HELD (kExists, names the
  /// holder), or a rate or limits that are off.
  [[nodiscard]] Outcome<core::StalenessLimits> open(const LeaseRequest& request,
                                                    core::TimePoint now);
  /// Gives it up, where it is this session's. Idempotent.
  void close(const std::string& session_id);

  /// Any thread. `why` as of Ingress::accept.
  IngressVerdict accept(const std::string& session_id, const PoseCandidate& candidate,
                        core::TimePoint arrival, std::string& why);

  /// Client name of the holder; empty: nobody.
  [[nodiscard]] std::string client_name() const;

 private:
  [[nodiscard]] IngressVerdict check(const PoseCandidate& candidate, std::string& why) const;

  core::Mailbox<core::TrackerSnapshot>& mailbox_;
  const core::StalenessLimits scene_;
  const std::optional<core::Duration> fresh_bound_;
  const core::Duration silence_;
  std::array<double, 3> lower_{}, upper_{};  ///< of the position, m

  mutable std::mutex mutex_;
  std::string session_id_{};  ///< empty: nobody has the place
  std::string client_name_{};
  core::TimePoint heard_{};  ///< newest accepted pose, or the opening
  std::uint64_t seq_{0};     ///< newest accepted of this session
  BacklogRule backlog_{};
  core::TrackerSnapshot newest_{};
};

}  // namespace haptic::server
