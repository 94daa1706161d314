#pragma once
/// A session on a device: publish proxies, receive states, ask for force.
///
/// Threads: on_state runs on the thread that received the state (gRPC's or the UDP path's), so that
/// nothing lies between the wire and your code: take what you need and return; while it runs,
/// states are conflated to the newest. A simulation's step belongs in a loop of its own, with wait_for_state(). on_event and
/// on_disconnect run on one thread of the session's own, and may take their time: events wait in
/// order. None runs twice at once, but on_state may run beside the other two. In a callback everything
/// of the session may be called but its destructor and, in on_state, wait_for_state(); the members may
/// be called from any thread.

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic/client/error.hpp"
#include "haptic/client/planes.hpp"
#include "haptic/client/pose.hpp"
#include "haptic/client/types.hpp"

namespace haptic::client {

enum class Reconnect : std::uint8_t {
  kNever,  ///< the session ends with its stream; a lease that expired leaves it as observer
  /// Taken up again at once, then after 0.1, 0.2, 0.4 ... 2 s, and with the first sample after a lease
  /// that is over, until the server says what no waiting can change. Within the lease the session is
  /// resumed: force, settings and sequence go on as if nothing had happened, event LEASE_RESUMED. Else
  /// it is opened anew, event LEASE_GRANTED; force never returns by itself then.
  kWithBackoff
};

/// Who may take a device from whom: only a higher one.
enum class Priority : std::uint8_t { kTest = 1, kPrimary = 2, kOperator = 3 };

/// What carries samples and states. The stream stays open beside UDP, and is its fallback.
enum class Carriers : std::uint8_t {
  kAutomatic,  ///< UDP where the server offers it and the path proves good, else the stream
  kGrpcOnly,
  kUdpOnly  ///< samples wait for no fallback: without the path they are dropped. For measuring.
};

struct SessionOptions {
  std::string device{};  ///< empty: the only one
  bool observer{false};
  bool tracker{false};  ///< says where the device's palm is: publish_pose(). Not both
  std::string client_name{"haptic client"};
  double nominal_rate_hz{60.0};  ///< of publish() or publish_pose(); not for an observer
  /// Where the server asks for certificates, at most what this client's allows.
  Priority priority{Priority::kPrimary};
  double state_rate_hz{0.0};  ///< 0: every tick
  /// Sends held proxies as planes, one per constrained block of `blocks` (planes.hpp), derived from
  /// the haptic probe of the state that the proxy was computed from: the one last given to the user.
  bool derive_planes{false};
  std::vector<Block> blocks{};  ///< empty: all coordinates are one
  std::optional<std::chrono::nanoseconds> fresh_end{}, hold_end{}, fade_end{};  ///< tighten only
  Carriers carriers{Carriers::kAutomatic};
  Reconnect reconnect{Reconnect::kNever};
  /// After force was lost (stale proxy, reconnect) ask for it again as soon as the server would
  /// agree. Never after a fault: clearing one must not start a motor. Ask again with
  /// engage_when_ready().
  bool re_engage{false};
  std::chrono::milliseconds timeout{5000};  ///< of calls that wait for an answer
  std::function<void(const DeviceState&)> on_state{};
  std::function<void(const Event&)> on_event{};
  /// The session lost its stream: once, with `will_retry` where it tries again, and once more, without,
  /// where that has become hopeless.
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

  /// Never waits for the network, never throws. The newest sample wins: one that could not be sent
  /// yet is replaced and counted; without a stream it is dropped. Only this call creates sequence
  /// numbers; they rise over reconnects too. `device_seq_used` 0 means the state that was last given
  /// to the user, by call or callback.
  void publish(Proxy proxy) noexcept;

  /// The same of a tracker's poses.
  void publish_pose(const Pose& pose) noexcept;

  /// The newest state; seq 0 before the first, also after a reconnect.
  [[nodiscard]] DeviceState state() const;
  /// Waits for a state newer than the last one this call returned. Throws kTimeout, kClosed, and
  /// kInvalidArgument in on_state, where it could only wait in vain.
  [[nodiscard]] DeviceState wait_for_state();

  /// Asks for force, once. Throws kNotReady naming what is missing.
  void engage();
  /// Asks for force as soon as the server would agree, in the background, every 50 ms. Idempotent.
  /// Ends with a refusal that time cannot cure, with a fault, and, without `re_engage`, with a loss.
  void engage_when_ready();
  /// Why engage_when_ready() has no force yet, or why it gave up; empty once the server agreed, and
  /// where nobody asks.
  [[nodiscard]] std::optional<ClientError> engage_refusal() const;
  /// Gives force up; it fades out. Also ends engage_when_ready(). Without a stream there is nothing
  /// to give up: returns.
  void release();
  AppliedSettings update(const Settings& settings);

  [[nodiscard]] bool connected() const;
  /// What is known of the UDP path; empty where the server offers none, or it was not wanted.
  [[nodiscard]] std::optional<UdpLink> udp_link() const;
  [[nodiscard]] std::uint32_t lease_epoch() const;
  [[nodiscard]] PublishStatistics statistics() const;
  [[nodiscard]] const DeviceInfo& device() const;

  /// Ends the session; force fades out at the server. When it returns no callback runs or will run;
  /// called in a callback it waits for none, and none begins any more. A session that reconnects says
  /// farewell, and gives the server 500 ms to hear it; no other waits for the server. The destructor
  /// does the same.
  void close();

 private:
  friend class Connection;
  class Impl;
  explicit Session(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic::client
