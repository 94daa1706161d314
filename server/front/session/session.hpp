#pragma once
/// One session as the network side sees it, whatever carries its messages. It opens the session at
/// the owner, passes samples and poses on, and keeps what the client is to be told: events,
/// acknowledgements, how the link does, and which state is due. The rights to the device are the
/// owner's.
///
/// Any thread; no call waits. A carrier (gRPC's stream, a datagram path) calls take() with what
/// arrives, due() and sent() around each state, and next() for everything else.

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "haptic/v1/haptic_service.pb.h"
#include "haptic/v1/session.pb.h"
#include "server/base/steady_now.hpp"
#include "server/front/session/front.hpp"
#include "server/front/session/link_watch.hpp"
#include "server/front/session/pace.hpp"
#include "server/front/session/sample_ledger.hpp"

namespace haptic::server {

/// Rights of the other end of a connection.
struct Rights {
  Priority highest{Priority::kOperator};
  std::string because{};  ///< "with this client's certificate"
  std::string bearer{};   ///< "certificate of 'surgeon'"; empty: it showed none
  bool control{true};     ///< false: as an observer only
};

/// Settings that all sessions of a front share.
struct SessionSettings {
  double loop_hz{1000.0};
  ArrivalClock clock{steady_arrival};
  bool age_by_source_time{true};  ///< ServiceLimits
  Carrier stream{Carrier::kGrpc};
};

class Session final : public SampleSource, public std::enable_shared_from_this<Session> {
 public:
  using ClockEstimate = std::optional<wire::ClockOffset::Estimate>;
  using Opened = std::function<void(const Outcome<v1::SessionOpened>&)>;

  /// `front` must outlive this.
  Session(Front& front, std::size_t device, const SessionSettings& settings);
  ~Session() override;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Once. Asks the owner for the session, then for the lease or the tracker's place if its role
  /// wants one; `opened` is called once, at once or when the owner answers, unless close() comes
  /// first. Refused without asking: fields that are off, a priority above its rights.
  void open(const v1::OpenSession& request, const Rights& rights, const Opened& opened);
  /// The session is over; `lost`: its stream broke, and it may be resumed. Idempotent.
  void close(bool lost);

  /// A sample that came by `carrier`. `path_clock`: the client's clock as the datagram path knows
  /// it.
  void take(const v1::ProxySample& message, core::TimePoint arrival, Carrier carrier,
            const ClockEstimate& path_clock);
  void take(const v1::TrackerSample& message, core::TimePoint arrival);
  void on_judged(const Judged& judged) override;

  /// Once per tick that may be sent; also decides whether an acknowledgement is due.
  [[nodiscard]] bool due(const SerialisedState& state);
  /// A tick that used a sample of this session.
  void used(const SerialisedState& state);
  /// The state was sent by `carrier`.
  void sent(const SerialisedState& state, Carrier carrier);
  /// The next event or acknowledgement; absent: there is none to send.
  [[nodiscard]] std::optional<v1::SessionResponse> next();
  /// The states go by `carrier` from now on, or samples did for a while.
  void tell_transport(const char* reason, const char* why);

  /// Everything but the figures of the datagram path itself. `path_clock` as for take().
  void report(v1::SessionLink& link, const ClockEstimate& path_clock) const;
  [[nodiscard]] CarrierFigures figures(Carrier carrier) const;

  [[nodiscard]] std::size_t device() const noexcept { return device_; }
  // Fixed before `opened` is called; not to be asked earlier.
  [[nodiscard]] const SessionId& id() const noexcept { return id_; }
  [[nodiscard]] const std::string& client_name() const noexcept { return client_name_; }
  /// Number by which the loop knows its lease; 0: it has none.
  [[nodiscard]] std::uint32_t tenure() const noexcept { return tenure_; }
  /// Period of the client's samples, or of its states if it sends none.
  [[nodiscard]] core::Duration nominal_period() const noexcept { return nominal_period_; }

 private:
  /// A client may change its carrier with every sample, as large and small ones take turns: its
  /// listeners are told so often, and no more.
  class TellLimit {
   public:
    static constexpr int kTold = 4;
    static constexpr core::Duration kIn{std::chrono::seconds(1)};
    [[nodiscard]] bool allows(core::TimePoint now) noexcept {
      if (now - since_ >= kIn) {
        since_ = now;
        told_ = 0;
      }
      return told_++ < kTold;
    }

   private:
    core::TimePoint since_{};
    int told_{0};
  };

  [[nodiscard]] std::optional<Refusal> refusal_of(const v1::OpenSession& request,
                                                  const Rights& rights) const;
  void admitted(const v1::OpenSession& request, const Rights& rights, const SessionId& id,
                const Opened& opened);
  void granted(const Rights& rights, const LeaseRequest& request, const Lease& lease,
               const Opened& opened);
  void tell_owner_of_end(const SessionId& id, bool lost);
  [[nodiscard]] v1::SessionOpened greeting(const Lease& lease) const;

  Front& front_;
  const std::size_t device_;
  const SessionSettings settings_;

  mutable std::mutex mutex_;
  bool closed_{false};
  bool lost_{false};  ///< if closed
  SessionId id_{};    ///< empty: not admitted yet
  std::string client_name_{};
  v1::Role role_{v1::ROLE_UNSPECIFIED};
  std::uint32_t epoch_{0};  ///< 0: never held the lease
  std::uint32_t tenure_{0};
  std::uint64_t ticket_{0};  ///< of its samples; 0: none yet
  std::shared_ptr<EventQueue> events_{};
  SampleLedger ledger_{};
  LinkWatch link_{};
  core::Duration nominal_period_{0};
  Carrier samples_by_{settings_.stream}, samples_told_by_{settings_.stream};
  Carrier states_by_{Carrier::kNone};
  TellLimit tell_limit_{};
  Pace pace_{1000.0, 0.0};
};

}  // namespace haptic::server
