#pragma once
/// The rights to one device: the lease, its epoch and clock, engage and release, settings within
/// the scene, clear and stop (proto/README.md#a-session). A plain state machine: requests, samples
/// and records come in with their times, answers and events go out. It knows neither thread nor
/// transport; its caller takes turns (server/owner/rights/owner.hpp).
///
/// A lease ends when its session closes, or by its clock, which every record brings. When it ends,
/// force fades out (RELEASING); the settings go back to the scene's once g = 0, so that the fade
/// itself never stiffens. A newcomer that comes during the fade is answered at g = 0. A session
/// that lost its stream may resume its lease while it lasts and no other session wants it. A higher
/// priority takes a lease from its holder.

#include <optional>
#include <string>
#include <vector>

#include "haptic/core/tick/tick_record.hpp"
#include "server/crossing/outcome.hpp"
#include "server/owner/ingress/ingress.hpp"
#include "server/owner/loop/device_unit.hpp"
#include "server/owner/rights/device_event.hpp"
#include "server/owner/rights/device_tracker.hpp"
#include "server/owner/rights/lease.hpp"
#include "server/owner/rights/pending_requests.hpp"
#include "server/owner/state/state_message.hpp"

namespace haptic::server {

struct SessionRules {
  core::Duration lease_timeout{std::chrono::seconds(2)};
  /// The scene's bound on every lease's fresh_end; absent: 2.5 nominal periods of the client.
  std::optional<core::Duration> fresh_end{};
  std::optional<core::Duration> tracker_fresh_end{};  ///< the same for a tracker's poses
};

/// Output of a call of DeviceSessions, each in the order in which it happened.
struct Outbox {
  std::vector<Answer> answers{};
  std::vector<DeviceEvent> events{};
};

/// SIGTERM came.
inline const Refusal kClosing{Refusal::Code::kUnavailable, "CLOSING",
                              "the server is shutting down"};

class DeviceSessions {
 public:
  /// `unit` must outlive this.
  DeviceSessions(DeviceUnit& unit, const SessionRules& rules);
  DeviceSessions(const DeviceSessions&) = delete;
  DeviceSessions& operator=(const DeviceSessions&) = delete;

  /// All kinds but kAdmit..., which the registry answers. A stop is posted to the loop before
  /// anything else is looked at.
  void handle(const Request& request);
  [[nodiscard]] Verdict accept(const ProxySample& sample) { return ingress_.accept(sample); }
  /// Precondition: the scene has a tracker, or no session was given its place.
  [[nodiscard]] Verdict accept(const PoseSample& pose);
  /// Every record, in order.
  void step(const core::TickRecord& record);
  /// SIGTERM: no new lease, force fades out, an event to every session. Idempotent.
  void begin_closing();
  /// The loop has ended: what waits for a tick, or would, is refused at once.
  void loop_ended();
  /// Output since the last call.
  [[nodiscard]] Outbox take();

  [[nodiscard]] const LeaseBook& lease() const noexcept { return lease_; }
  /// A controller that opens now with this `resume` would go on with the lease of that session,
  /// whether or not its stream is known to be lost.
  [[nodiscard]] bool would_resume(const SessionId& resume) const noexcept;
  /// All but the numbers of sessions.
  [[nodiscard]] DeviceStatus status() const;
  /// `record` and what the loop does not know: who carried the sample in use, and the epoch of its
  /// lease as clients know it.
  [[nodiscard]] TickTold told(const core::TickRecord& record) const noexcept;

 private:
  struct Newcomer {
    std::uint64_t id{0};  ///< of the request
    LeaseRequest request{};
    core::StalenessLimits staleness{};
    core::TimePoint gives_up{};
    ClientName taken_from{};  ///< client name of the preempted holder
    bool granted{false};      ///< the lease is in the book already: it was taken from its holder
  };

  void answer(std::uint64_t id, const Refusal& refusal);
  Answer& answer(std::uint64_t id);
  void tell(DeviceEvent::Kind kind, const char* reason, const std::string& message);
  void post() noexcept;
  void post_next_clear() noexcept;
  /// Engage or release, by the holder only.
  void ask_loop(const Request& request, std::uint64_t& counter);
  void clear_faults(const Request& request);
  void update_settings(const Request& request);
  void cancel(std::uint64_t id);
  void take_engage_back();
  // device_lease.cpp
  void open(const Request& request);
  void open_tracker(const Request& request);
  void close(const Request& request);
  [[nodiscard]] bool resumes(const SessionId& former) const noexcept;
  void resume_lease(const LeaseRequest& request, core::TimePoint now, std::uint64_t id);
  void wait_for_lease(Newcomer newcomer, core::TimePoint now);
  void grant_newcomer(core::TimePoint now);
  void refuse_newcomer(const Refusal& why);
  void look_after_lease(const core::TickRecord& record);
  void end_lease();
  void tell_lease(const char* reason, const std::string& message);

  void publish_settings(core::RenderSettings settings);
  [[nodiscard]] bool force_is_on() const noexcept;
  [[nodiscard]] std::optional<Refusal> not_holder(const SessionId& session_id) const;

  DeviceUnit& unit_;
  const SessionRules rules_;
  Ingress ingress_;
  std::optional<DeviceTracker> tracker_;
  LeaseBook lease_;
  std::optional<Newcomer> newcomer_;  ///< waits for the force of the previous holder to fade out
  PendingRequests pending_;
  core::CommandSnapshot command_{};
  core::RenderSettings settings_{};
  bool loop_ended_{false};
  bool settings_due_{false};  ///< the scene's settings are to be restored when g = 0
  EventDetector detector_;
  std::string stop_reason_{};
  /// A stop came by the local control socket, which alone clears it; false again when the loop says
  /// that no stop is on.
  bool stopped_locally_{false};
  /// Values of the newest record for which the calls after it ask.
  struct Seen {
    core::TimePoint now{};
    core::LifecycleState state{core::LifecycleState::kInit};
    core::FaultSet faults{};
    std::uint64_t stop_id{0}, engage_id{0};
    double gain{0.0};
    bool lease_held{false};
    std::uint32_t tenure{0};
  } seen_{};
  Outbox out_{};
};

}  // namespace haptic::server
