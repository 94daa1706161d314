#pragma once
/// Every value that crosses between the owner of the devices (the loop, sessions and their rights)
/// and the front (what faces the network). Each is trivially copyable and has a fixed layout: its
/// bytes can go to another process. Nothing here points, owns or calls.
///
///   front -> owner   Request with an id; ProxySample, PoseSample
///   owner -> front   Answer with the request's id; Judged; DeviceEvent, SerialisedState and status
///
/// Every bit pattern of what goes to the owner is a valid value, so a broken front can do no harm.
///
/// The front keeps its own map from an id to the call that waits for the answer. A front that is
/// gone looks like a client that fell silent: samples stop, and leases end by their clock.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "haptic/core/contacts/proxy_snapshot.hpp"
#include "haptic/core/fault.hpp"
#include "haptic/core/rendering/renderer_kind.hpp"
#include "haptic/core/safety/lifecycle.hpp"
#include "haptic/core/safety/staleness.hpp"
#include "haptic/core/time.hpp"
#include "haptic/core/types.hpp"
#include "server/crossing/layout.hpp"
#include "server/crossing/plain.hpp"
#include "server/crossing/priority.hpp"
#include "server/crossing/serialised_state.hpp"
#include "server/crossing/text.hpp"
#include "server/crossing/values.hpp"

namespace haptic::server {

/// 128 random bits in hexadecimal. A program that knows it speaks for the session.
using SessionId = Text<32>;
using ClientName = Text<64>;

/// n x <= b and what makes it a contact, as it came off the wire. The numbers of the curvature lie
/// behind those of the normal, so that the record stays small: all blocks of 8 coordinates fit on a
/// device with up to 44, and those of 3 on one with 72.
struct PlaneSample {
  static constexpr std::size_t kNumbers = 80;
  Numbers<kNumbers> normal{};  ///< its count is the normal's alone
#include "server/crossing/plane_fields.inc"
  std::uint32_t curvature_count{0};
  Numbers<core::kMaxMotions> object_direction{};
};

/// When a sample left its source, by a synchronised clock (proto/README.md#clock-and-age).
struct Departure {
  core::TimePoint likely{};  ///< by the estimate itself: what moves goes on from there
  core::TimePoint latest{};  ///< by the bound of its error: the age counts from there
};

/// A sample of the proxy as it came off the wire: nothing was checked but its syntax. Counts are
/// the wire's and may be above what the arrays hold; such a sample is refused.
struct ProxySample {
  std::uint64_t ticket{0};  ///< the front's: whose it is (Judged)
  std::uint32_t device{0};
  std::uint32_t epoch{0};  ///< of the lease it is sent under
  std::uint64_t seq{0};
  core::TimePoint arrival{};
  core::Duration valid_for{0};
  Maybe<Departure> left{};
  core::ProxyMode mode{core::ProxyMode::kNone};  ///< kNone: the wire named no known mode
  Carrier carrier{Carrier::kGrpc};
  std::uint32_t plane_count{0};
  std::uint64_t tick_used{0};  ///< device_seq_used; 0: none
  Coordinates position{};
  std::array<PlaneSample, core::kMaxPlanes> planes{};

  /// The bytes before the planes, and those up to the last plane that it has: these alone cross.
  [[nodiscard]] static std::size_t head_bytes() noexcept { return offsetof(ProxySample, planes); }
  [[nodiscard]] std::size_t told_bytes() const noexcept {
    return head_bytes() + std::min<std::size_t>(plane_count, planes.size()) * sizeof(PlaneSample);
  }
};

/// A pose of the tracked palm as it came off the wire; counts as in ProxySample.
struct PoseSample {
  std::uint64_t ticket{0};  ///< as in ProxySample
  std::uint32_t device{0};
  SessionId session_id{};
  std::uint64_t seq{0};
  core::TimePoint arrival{};
  core::Duration valid_for{0};
  Numbers<3> position{};     ///< m
  Numbers<4> orientation{};  ///< x, y, z, w
};

enum class IngressVerdict : std::uint8_t {
  kAccepted,
  kBacklog,  ///< accepted as the newest, but not as fresh (faster than twice the nominal rate)
  kOldSequence,
  kOldEpoch,  ///< of a lease that has ended
  kWrongSize,
  kNotFinite,
  kOutOfBounds,  ///< |position| > 1000 (m or rad)
  kUnknownMode,
  kBadPlane,  ///< too many, of a wrong size, not finite, too large, or without a direction
};

/// The answer to a sample.
struct Verdict {
  IngressVerdict verdict{IngressVerdict::kAccepted};
  Text<183> why{};  ///< for kOldSequence and below: field, value and what is allowed

  [[nodiscard]] bool used() const noexcept { return verdict <= IngressVerdict::kBacklog; }
};

/// The verdict on one sample, and which one that is.
struct Judged {
  std::uint64_t ticket{0};
  std::uint64_t seq{0};
  Carrier carrier{Carrier::kNone};
  Verdict verdict{};
};

inline constexpr std::size_t kIngressVerdicts = 9;
/// Samples by what became of them: indices are IngressVerdict's.
struct IngressCounters {
  std::array<std::uint64_t, kIngressVerdicts> count{};
  [[nodiscard]] std::uint64_t operator[](IngressVerdict verdict) const noexcept {
    return count[static_cast<std::size_t>(verdict)];
  }
};

/// Asks for the lease of a device, or for the place of its tracker.
struct LeaseRequest {
  SessionId session_id{};
  ClientName client_name{};
  double nominal_rate_hz{0.0};
  Priority priority{Priority::kPrimary};
  Flag resumable{};    ///< its lease outlives the loss of its stream
  SessionId resume{};  ///< session whose lease is to go on; empty: none
  Maybe<core::Duration> fresh_end{};
  Maybe<core::Duration> hold_end{};
  Maybe<core::Duration> fade_end{};
};

/// A lease that was granted. The epoch is its number for clients and rises with every grant and
/// every resume; the tenure is its number for the loop, which a resume does not change.
struct Lease {
  std::uint32_t epoch{0};
  core::StalenessLimits staleness{};  ///< in force
  std::uint32_t tenure{0};
  bool resumed{false};
  std::uint64_t newest_seq{0};  ///< accepted so far
  ClientName taken_from{};      ///< holder that had to give way; empty: the device was free
};

/// Settings that a session may ask to change; absent and empty leave a setting as it is.
struct SettingsRequest {
  Values stiffness{}, damping{}, force_limit{}, slew_limit{};  ///< n_a each
  Maybe<core::RendererKind> renderer{};
  Maybe<Flag> direction_guard{};
};

/// The settings in effect after a request.
struct Settings {
  Values stiffness{}, damping{}, force_limit{}, slew_limit{};  ///< n_a each
  core::RendererKind renderer{core::RendererKind::kSubspaceLinear};
  bool direction_guard{false};
};

/// Why a request was refused: a stable reason ("LEASE_HELD") and a sentence for people.
struct Refusal {
  /// Numbers of google.rpc.Code.
  enum class Code : std::uint8_t {
    kInvalid = 3,           ///< a field is off, whatever the state; `field` names it
    kNotFound = 5,          ///< no such device or session
    kExists = 6,            ///< another session has it
    kPermission = 7,        ///< not this session's to ask
    kExhausted = 8,         ///< a limit of the server is reached
    kPrecondition = 9,      ///< not now; the message names the value that is not good enough yet
    kAborted = 10,          ///< another call took this one's place
    kUnavailable = 14,      ///< the server is closing, or its loop gave no answer in time
    kUnauthenticated = 16,  ///< neither token nor certificate
  };
  /// {"holder", "alice"}
  struct Detail {
    Text<12> name{};
    ClientName value{};
  };
  using Details = std::array<Detail, 3>;  ///< those without a name are not there
  Code code{Code::kInvalid};
  Text<32> reason{};
  Text<512> message{};
  Text<64> field{};   ///< kInvalid: the field that is off
  Details details{};  ///< for programs
};

struct Request {
  enum class Kind : std::uint8_t {
    kAdmitSession,   ///< a controller or tracker comes to `device`; answered with its id
    kAdmitObserver,  ///< the same for an observer
    kAdmitWatch,     ///< the same for a watch
    kClose,          ///< the session or watch is over; no answer
    kLose,           ///< its stream broke: a resumable session may come back; no answer
    kOpen,   ///< `lease`: the lease of `device`; answered when the force of the last is gone
    kTrack,  ///< `lease`: the place of the tracker of `device`
    kEngage,
    kRelease,
    kSettings,  ///< `settings`
    kStop,      ///< emergency stop of `device`; `text`: why
    kClear,     ///< `faults` of `device`; empty: all that are active
    kCancel,    ///< request `id` needs no answer any more; no answer
  };
  std::uint64_t id{0};  ///< unique while the request is open
  Kind kind{Kind::kAdmitSession};
  std::uint32_t device{0};  ///< kAdmit..., kOpen, kTrack, kStop, kClear; else the session says it
  SessionId session_id{};   ///< who asks; kAdmitSession: whose lease it wants to resume, or empty
  LeaseRequest lease{};
  SettingsRequest settings{};
  core::FaultSet faults{};
  Text<200> text{};
  core::TimePoint time{};  ///< when it was asked, on the server's steady clock
  Flag local{};            ///< kStop, kClear: by the local control socket
};

struct Answer {
  std::uint64_t id{0};
  std::optional<Refusal> refusal{};
  SessionId session_id{};   ///< kAdmit...
  Lease lease{};            ///< kOpen; kTrack: its staleness
  Settings settings{};      ///< kSettings
  core::FaultSet faults{};  ///< kClear: those that were cleared
};

/// An event of a device, told once.
struct DeviceEvent {
  enum class Kind : std::uint8_t {
    kState = 1,         ///< reason "ENGAGED -> ARMED"
    kLost = 2,          ///< force was given up, proxy too old; reason "LOST"
    kFault = 3,         ///< reason: the fault's
    kFaultCleared = 4,  ///< reason: the fault's
    kLeaseExpired = 5,  ///< reason "LEASE_EXPIRED"
    kStaleness = 6,     ///< reason "FRESH -> HOLD"
    kClosing = 7,       ///< reason "CLOSING"
    kTransport = 8,     ///< of one session, by the front; reason "SAMPLES GRPC -> UDP"
    kLease = 9,         ///< reason "LEASE_GRANTED", "LEASE_RESUMED", ...
    kClamp = 10,        ///< reason "CLAMPED": a setting was held at the scene's
    kLimiter = 20,      ///< a limit of an actuator began to act; reason: the limiter's
  };
  Kind kind{Kind::kState};
  core::TimePoint time{};  ///< server's steady clock, of the tick
  Text<40> reason{};       ///< stable
  Text<400> message{};     ///< for people
  core::LifecycleState state{core::LifecycleState::kInit};
  std::uint32_t lease_epoch{0};  ///< the lease it happened under; 0: under none
};

/// Frames on the link to a device: who counted ("host", "board") and what became of them.
struct LinkFrames {
  Text<8> end{};
  Text<20> what{};
  std::uint64_t frames{0};
};

/// A device as lists and metrics show it.
struct DeviceStatus {
  core::TimePoint ticked{};  ///< time of the newest tick; TimePoint{} before the first
  core::LifecycleState state{core::LifecycleState::kInit};
  core::FaultSet faults{};
  core::RendererKind renderer{core::RendererKind::kSubspaceLinear};
  ClientName controller{};            ///< client name of the lease's holder; empty: none
  SessionId holder{};                 ///< its session
  ClientName tracker{};               ///< client name; empty: none
  bool detached{false};               ///< the holder lost its stream
  std::uint32_t sessions{0};          ///< session streams on this device
  std::uint32_t observers{0};         ///< sessions and watches that do not hold the lease
  Carrier carrier{Carrier::kNone};    ///< of the newest accepted sample of the lease
  IngressCounters samples{};          ///< since the start
  std::uint64_t records_dropped{0};   ///< ticks that the drain missed
  std::array<LinkFrames, 16> link{};  ///< the first link_count are set
  std::uint32_t link_count{0};
};

template <std::size_t N>
inline constexpr bool kAnyBits<Numbers<N>> = true;
static_assert(any_bits<ProxySample>() && any_bits<PoseSample>() && any_bits<Request>());

}  // namespace haptic::server
