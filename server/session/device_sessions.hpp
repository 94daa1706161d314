#pragma once
/// Who has what of a device: the lease, its epoch and clock, engage and release, settings within
/// the scene, clear and stop (proto/README.md#a-session). No gRPC here: time and records come in,
/// verdicts go out, so that every rule runs on virtual time.
///
/// A lease ends when its session closes, or by the clock: every record that the telemetry drains
/// brings the time, so it ends on time whether or not anybody calls anything. When it ends, force
/// fades out (RELEASING); the settings go back to the scene's once g = 0, so that the fade itself
/// never stiffens. A newcomer who comes during the fade is answered when g = 0. A session that lost
/// its stream may resume its lease while that lasts and nobody else wants it; a higher priority
/// takes it from whoever has it.
///
/// Threads: every method from any thread. Answers are called without a lock held, on the caller's
/// thread where the answer is known at once, else on the telemetry drain's; they must not block.

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "haptic/core/tick/tick_record.hpp"
#include "server/ingress/ingress.hpp"
#include "server/rt/device_unit.hpp"
#include "server/session/device_event.hpp"
#include "server/session/device_tracker.hpp"
#include "server/session/lease.hpp"
#include "server/session/pending_requests.hpp"
#include "server/session/refusal.hpp"
#include "server/session/settings_policy.hpp"
#include "server/telemetry/telemetry.hpp"

namespace haptic::server {

struct SessionRules {
  core::Duration lease_timeout{std::chrono::seconds(2)};
  /// The scene's bound on every lease's fresh_end; absent: 2.5 nominal periods of the client.
  std::optional<core::Duration> fresh_end{};
  std::optional<core::Duration> tracker_fresh_end{};  ///< the same of a tracker's poses
  /// Softness of the coupling metric that states carry (core/METHOD.md#anisotropic-coupling);
  /// absent: none.
  std::optional<double> coupling_softness{};
};

using LeaseAnswer = std::function<void(const Outcome<Lease>&)>;

class DeviceSessions final : public RecordListener {
 public:
  /// Listens to unit `index` of `telemetry` for as long as it lives; both must outlive it.
  DeviceSessions(DeviceUnit& unit, Telemetry& telemetry, std::size_t index, SessionRules rules);
  ~DeviceSessions() override;
  DeviceSessions(const DeviceSessions&) = delete;
  DeviceSessions& operator=(const DeviceSessions&) = delete;

  [[nodiscard]] const std::string& name() const noexcept { return unit_.name(); }
  [[nodiscard]] const DeviceUnit& unit() const noexcept { return unit_; }
  [[nodiscard]] Ingress& ingress() noexcept { return ingress_; }
  /// None where the scene has no tracker.
  [[nodiscard]] DeviceTracker* tracker() noexcept { return tracker_ ? &*tracker_ : nullptr; }
  [[nodiscard]] const DeviceTracker* tracker() const noexcept {
    return tracker_ ? &*tracker_ : nullptr;
  }
  [[nodiscard]] core::Duration lease_timeout() const noexcept { return rules_.lease_timeout; }
  [[nodiscard]] std::optional<double> coupling_softness() const noexcept {
    return rules_.coupling_softness;
  }

  /// The session's events from now on, until close(). Every session subscribes, whatever its role.
  [[nodiscard]] std::shared_ptr<EventQueue> subscribe(const std::string& session_id);
  enum class Ending : std::uint8_t {
    kGivenUp,  ///< on purpose, by either end
    kLost,     ///< the stream broke: a resumable session may come back
  };
  /// The session is over, its events stop. Its lease ends; where it was lost and is resumable it is
  /// detached instead. Idempotent.
  void close(const std::string& session_id, Ending ending = Ending::kGivenUp);

  /// Asks for the lease: to resume one, a free one, or that of a lower priority. Refused:
  /// LEASE_HELD (kExists, names the holder), CLOSING, or limits that are off. Answered at g = 0; at
  /// once where it resumes.
  void open_controller(const LeaseRequest& request, core::TimePoint now, const LeaseAnswer& answer);

  /// Each returns a ticket for cancel(), 0 where the answer was given at once.
  Ticket engage(const std::string& session_id, const Answer& answer);
  Ticket release(const std::string& session_id, const Answer& answer);
  /// Posted before anything else is looked at; answered by the tick that latched.
  Ticket emergency_stop(const std::string& reason, Answer answer);
  /// `faults` empty: all that are active. Answered with what was cleared.
  Ticket clear_faults(core::FaultSet faults, ClearAnswered answer);
  /// Gives up on an answer; false where it was given already.
  bool cancel(Ticket ticket);

  [[nodiscard]] Outcome<SettingsAnswer> update_settings(const std::string& session_id,
                                                        const SettingsRequest& request);

  /// SIGTERM: no new lease, force fades out, an event to everyone. Idempotent.
  void begin_closing();

  [[nodiscard]] bool holds_lease(const std::string& session_id) const;
  /// Client name of the holder; empty: nobody.
  [[nodiscard]] std::string controller() const;
  /// Sessions that do not hold the lease.
  [[nodiscard]] unsigned observers() const;
  [[nodiscard]] core::RenderSettings settings() const;
  /// The newest record seen; a default one before the first tick.
  [[nodiscard]] core::TickRecord newest() const;

  /// Who carried the sample in use of a record, and the epoch of its lease as clients know it: the
  /// loop knows neither.
  struct Stamp {
    Carrier carrier{Carrier::kNone};
    std::uint32_t lease_epoch{0};
  };
  [[nodiscard]] Stamp stamp(const core::TickRecord& record) const noexcept;
  /// Its lease waits for it.
  [[nodiscard]] bool may_be_resumed(const std::string& session_id) const;
  /// A controller that opens now with this `resume` would go on with the lease of that session,
  /// whether or not its stream is known to be lost.
  [[nodiscard]] bool would_resume(const std::string& resume) const;

  /// Telemetry's call, every tick.
  void on_record(const core::TickRecord& record) override;

 private:
  struct Newcomer {
    LeaseRequest request{};
    core::StalenessLimits staleness{};
    LeaseAnswer answer{};
    core::TimePoint gives_up{};
    std::string taken_from{};  ///< client name of the preempted holder
    bool granted{false};       ///< the lease is in the book already: it was taken from somebody
  };
  using Closures = PendingRequests::Closures;

  [[nodiscard]] Outcome<Done> explained(Outcome<Done> outcome) const;
  void post() noexcept;
  void post_next_clear() noexcept;
  // device_lease.cpp
  [[nodiscard]] bool resumes(const std::string& former) const noexcept;
  void resume_lease(const LeaseRequest& request, core::TimePoint now, const LeaseAnswer& answer,
                    Closures& closures);
  void wait_for_lease(Newcomer newcomer, core::TimePoint now, Closures& closures);
  void grant_newcomer(core::TimePoint now, Closures& closures);
  void look_after_lease(const core::TickRecord& record, Closures& closures);
  void end_lease(Closures& closures);
  void tell_lease(const char* reason, std::string message);

  void restore_scene_settings();
  void publish_settings(core::RenderSettings settings);
  void tell_everyone(const DeviceEvent& event);
  [[nodiscard]] bool force_is_on() const noexcept;
  [[nodiscard]] std::optional<Refusal> not_holder(const std::string& session_id) const;

  DeviceUnit& unit_;
  Telemetry& telemetry_;
  const std::size_t index_;
  const SessionRules rules_;
  Ingress ingress_;
  std::optional<DeviceTracker> tracker_;

  mutable std::mutex mutex_;
  LeaseBook lease_;
  std::atomic<std::uint32_t> resumes_{0};  ///< lease_'s, for whoever has no mutex
  std::optional<Newcomer> newcomer_;  ///< waits for the force of the previous holder to fade out
  PendingRequests pending_;
  core::CommandSnapshot command_{};
  core::RenderSettings settings_{};
  bool settings_due_{false};  ///< the scene's settings are to be restored when g = 0
  std::map<std::string, std::shared_ptr<EventQueue>> queues_;
  EventDetector detector_;
  std::string stop_reason_{};
  core::TickRecord newest_{};
};

}  // namespace haptic::server
