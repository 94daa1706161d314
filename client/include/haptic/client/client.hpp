#pragma once
/// haptic::client - the C++ client of hapticd. No gRPC, protobuf or Eigen type appears here.
///
///   haptic::client::Connection server("127.0.0.1:50051");
///   auto session = server.open({.client_name = "my simulation", .nominal_rate_hz = 60});
///   session->engage_when_ready();
///   for (...) {
///     haptic::client::DeviceState state = session->wait_for_state();
///     session->publish(haptic::client::Proxy::held(step(state.x_probe)));
///   }
///
/// SI units throughout; arrays in the order of DeviceInfo. Threads: callbacks run on one thread of the
/// library's own, one at a time, and must not block for long; everything else may be called from any
/// thread. Destructors close what is open and join.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace haptic::client {

enum class ErrorReason : std::uint8_t {
  kUnreachable,         ///< no server there, or it went away
  kTimeout,             ///< no answer in time
  kNoSuchDevice,
  kLeaseHeld,           ///< another controller has the device; the message names it
  kInvalidArgument,     ///< the message names field, value and what is allowed
  kNotReady,            ///< Engage or ClearFault: the message names what is not good enough yet
  kPermissionDenied,    ///< not this session's to ask
  kClosed,              ///< the session ended
  kProtocol,            ///< the server answered what this library does not understand
};

/// Every error of the library, thrown by calls that wait for an answer.
class ClientError : public std::runtime_error {
 public:
  ClientError(ErrorReason reason, const std::string& message, std::string server_reason = {})
      : std::runtime_error(message), reason_(reason), server_reason_(std::move(server_reason)) {}
  [[nodiscard]] ErrorReason reason() const noexcept { return reason_; }
  /// The server's stable reason string, e.g. "STREAM_TOO_YOUNG"; empty where there was none.
  [[nodiscard]] const std::string& server_reason() const noexcept { return server_reason_; }

 private:
  ErrorReason reason_;
  std::string server_reason_;
};

enum class Mode : std::uint8_t { kHeld = 1, kFree = 2 };
enum class Staleness : std::uint8_t { kUnknown = 0, kFresh = 1, kHold = 2, kFade = 3, kLost = 4 };
enum class Transport : std::uint8_t { kUnknown = 0, kGrpc = 1, kUdp = 2 };
enum class State : std::uint8_t {
  kUnknown = 0, kInit = 1, kIdle = 2, kArmed = 3, kEngaging = 4, kEngaged = 5, kReleasing = 6,
  kFault = 7, kClosing = 8,
};
enum class Renderer : std::uint8_t {
  kUnchanged = 0, kStandard = 1, kNullSpace = 2, kSubspaceLinear = 3, kSubspaceExact = 4,
};
[[nodiscard]] const char* name(State state) noexcept;          ///< "ENGAGED"
[[nodiscard]] const char* name(Staleness staleness) noexcept;  ///< "FRESH"
[[nodiscard]] const char* name(Transport transport) noexcept;  ///< "GRPC"

struct DegreeOfFreedom {
  std::string name{}, unit{};  ///< unit "m" or "rad"
  bool actuated{false};
  double lower{0.0}, upper{0.0};
  double max_effort{0.0};  ///< N or N m
};

struct VirtualCoordinate {
  std::string name{}, unit{}, kind{};
};

struct DeviceInfo {
  std::string name{}, kind{}, model{}, serial{};
  bool moves{true};
  std::vector<DegreeOfFreedom> dofs{};
  std::vector<VirtualCoordinate> coordinates{};
  std::vector<double> stiffness_limit{}, damping_limit{}, force_limit{}, slew_limit{},
      engage_window{};  ///< per actuated DoF
  double loop_rate_hz{0.0};
  State state{State::kUnknown};
  std::uint32_t faults{0};
  std::string controller{};  ///< who holds the lease; empty: nobody
  Renderer renderer{Renderer::kUnchanged};
  unsigned observers{0};
};

struct ServerInfo {
  std::string version{}, protocol{}, scene{};
  std::string realtime_grade{}, realtime_explanation{};
  std::vector<std::string> insecure{};
  std::uint64_t ticks{0}, skipped_ticks{0}, records_dropped{0};
  double lateness_p50_us{0.0}, lateness_p99_us{0.0}, lateness_max_us{0.0};
  double tick_p50_us{0.0}, tick_p99_us{0.0};
  unsigned sessions{0};
  std::chrono::nanoseconds uptime{0};
};

/// The device at one tick. Field by field as DeviceState in proto/haptic/v1/session.proto.
struct DeviceState {
  std::uint64_t seq{0};
  std::int64_t server_time_ns{0};
  std::vector<double> q{}, q_dot{}, x_probe{}, x{}, q_star{}, tau_a{}, tau_elastic{},
      stiffness_in_effect{};
  std::uint64_t proxy_seq_used{0};
  std::chrono::microseconds proxy_age{0};
  Staleness staleness{Staleness::kUnknown};
  double gain{0.0};
  Transport transport{Transport::kUnknown};
  State state{State::kUnknown};
  std::uint32_t faults{0}, limiters{0};
  unsigned projection{0};
  double condition{0.0};
  std::uint32_t lease_epoch{0};
  Mode mode{Mode::kFree};
  /// This machine's steady clock when the state arrived.
  std::chrono::steady_clock::time_point received{};
};

struct Event {
  unsigned kind{0};  ///< number of Event.Kind in session.proto
  std::string reason{}, message{};
  State state{State::kUnknown};
  std::int64_t server_time_ns{0};
};

/// One state of the proxy in the simulation.
struct Proxy {
  Mode mode{Mode::kFree};
  std::vector<double> position{};  ///< per virtual coordinate; may be empty when free
  std::uint64_t device_seq_used{0};
  std::chrono::microseconds valid_for{0};  ///< 0: the scene's limit alone

  [[nodiscard]] static Proxy held(std::vector<double> x) { return {Mode::kHeld, std::move(x), 0, {}}; }
  [[nodiscard]] static Proxy free() { return {}; }
};

/// Samples since the session opened.
struct PublishStatistics {
  std::uint64_t published{0};   ///< calls of publish()
  std::uint64_t sent{0};        ///< handed to the transport
  std::uint64_t conflated{0};   ///< replaced by a newer one before they could be sent
  std::uint64_t accepted{0}, rejected_old{0}, rejected_invalid{0}, backlog{0};  ///< server's word
  std::string last_rejection{};
};

enum class Reconnect : std::uint8_t {
  kNever,       ///< the session ends with its stream
  kWithBackoff  ///< opened anew after 0.1, 0.2, 0.4 ... 2 s; force never returns by itself
};

struct SessionOptions {
  std::string device{};  ///< empty: the only one
  bool observer{false};
  std::string client_name{"haptic client"};
  double nominal_rate_hz{60.0};  ///< of publish(); controller only
  double state_rate_hz{0.0};     ///< 0: every tick
  std::optional<std::chrono::nanoseconds> fresh_end{}, hold_end{}, fade_end{};  ///< tighten only
  Reconnect reconnect{Reconnect::kNever};
  /// After force was lost (stale proxy, reconnect) ask for it again as soon as the server would agree.
  bool re_engage{false};
  std::chrono::milliseconds timeout{5000};  ///< of calls that wait for an answer
  std::function<void(const DeviceState&)> on_state{};
  std::function<void(const Event&)> on_event{};
  /// The session ended (or lost its stream and will try again: `will_retry`).
  std::function<void(const ClientError&, bool will_retry)> on_disconnect{};
};

struct Settings {
  std::vector<double> stiffness{}, damping{}, force_limit{}, slew_limit{};  ///< empty: unchanged
  Renderer renderer{Renderer::kUnchanged};
  std::optional<bool> direction_guard{};
};

struct AppliedSettings {
  Settings applied{};
  struct Clamp {
    std::string field{};
    double asked{0.0}, applied{0.0};
    std::string why{};
  };
  std::vector<Clamp> clamped{};
};

class Session {
 public:
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Never blocks, never throws. The newest sample wins: one that could not be sent yet is replaced
  /// and counted. Only this call creates sequence numbers.
  void publish(Proxy proxy) noexcept;

  /// The newest state; seq 0 before the first.
  [[nodiscard]] DeviceState state() const;
  /// Waits for a state newer than the last one this call returned. Throws kTimeout, kClosed.
  [[nodiscard]] DeviceState wait_for_state();

  /// Asks for force, once. Throws kNotReady naming what is missing.
  void engage();
  /// Asks for force as soon as the server would agree, in the background. Idempotent.
  void engage_when_ready();
  /// Gives force up; it fades out. Also ends engage_when_ready().
  void release();
  AppliedSettings update(const Settings& settings);

  [[nodiscard]] bool connected() const;
  [[nodiscard]] Transport transport() const;
  [[nodiscard]] std::uint32_t lease_epoch() const;
  [[nodiscard]] PublishStatistics statistics() const;
  [[nodiscard]] const DeviceInfo& device() const;

  /// Ends the session; force fades out at the server. The destructor does the same.
  void close();

 private:
  friend class Connection;
  class Impl;
  explicit Session(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Telemetry of a device until destroyed.
class Watch {
 public:
  ~Watch();
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;
  /// False once the stream ended; error() says why.
  [[nodiscard]] bool running() const;
  [[nodiscard]] std::optional<ClientError> error() const;
  /// States the server left out because it or this stream was busy.
  [[nodiscard]] std::uint64_t conflated() const;

 private:
  friend class Connection;
  class Impl;
  explicit Watch(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

class Connection {
 public:
  /// "host:port" or "unix:/path". Does not wait for the server.
  explicit Connection(const std::string& address);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  [[nodiscard]] ServerInfo server_info(std::chrono::milliseconds timeout = std::chrono::seconds(5));
  [[nodiscard]] std::vector<DeviceInfo> devices(
      std::chrono::milliseconds timeout = std::chrono::seconds(5));

  /// Opens a session and waits for the server's word. Throws ClientError. The session may outlive the
  /// connection.
  [[nodiscard]] std::unique_ptr<Session> open(SessionOptions options);

  /// `rate_hz` 0: the server's default.
  [[nodiscard]] std::unique_ptr<Watch> watch(const std::string& device, double rate_hz,
                                             std::function<void(const DeviceState&)> on_state,
                                             std::function<void(const Event&)> on_event = {});

  /// Needs no session. Returns the devices now in FAULT. Device empty: all.
  std::vector<std::string> emergency_stop(const std::string& device = {},
                                          const std::string& reason = {});
  /// `faults` empty: all that are active. Returns what was cleared; throws kNotReady where a cause
  /// persists.
  std::vector<std::uint32_t> clear_fault(const std::string& device = {},
                                         const std::vector<std::uint32_t>& faults = {});

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic::client
