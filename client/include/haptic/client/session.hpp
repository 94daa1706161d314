#pragma once
/// A session with one device: publish where the proxy is, receive the device's states, ask for
/// force. Connection::open() makes one.
///
/// Words. The *haptic probe* is where the device is in the virtual space; the *proxy* is where the
/// simulation's objects let it be. The server renders a force that pulls the probe to the proxy.
/// The *lease* is a controller's right to the device; it expires after a while without samples.
///
/// Threads. Every member may be called from any thread. Three callbacks run on the library's
/// threads:
/// - on_state runs on the thread that received the state, so that it is called without delay. It
///   should copy the state and return. States that arrive while it runs are not queued: the next
///   call brings the newest of them. Run the simulation in a loop of your own, with
///   wait_for_state().
/// - on_event and on_disconnect share one thread and may take their time: events are queued.
///
/// No callback runs twice at once, but on_state may run at the same time as one of the other two.
/// A callback may call every member but wait_for_state() (in on_state), and must not destroy the
/// session. An exception that a callback throws is dropped.

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "haptic/client/error.hpp"
#include "haptic/client/planes.hpp"
#include "haptic/client/pose.hpp"
#include "haptic/client/types.hpp"

namespace haptic::client {

/// Behaviour of a session that loses its stream.
enum class Reconnect : std::uint8_t {
  kNever,  ///< the session ends
  /// The session opens another stream: at once, then after 0.1, 0.2, 0.4, 0.5, 0.5 ... s. It gives
  /// up when the server refuses for a reason that no waiting changes, such as a wrong argument.
  /// If the lease has not expired by then, the session is resumed: force, settings and numbers go
  /// on (event LEASE_RESUMED). Otherwise it starts again with a new lease and without force (event
  /// LEASE_GRANTED). After a lease expired or was preempted, the next published sample starts it
  /// again.
  kWithBackoff
};

/// Which carriers a session may use. The gRPC stream stays open in every case.
enum class Carriers : std::uint8_t {
  kAutomatic,  ///< UDP while the server offers it and it works, otherwise the stream
  kGrpcOnly,
  kUdpOnly  ///< drops samples while UDP does not work; for measurements
};

struct SessionOptions {
  std::string device{};  ///< its name; empty: the only device of the server
  bool observer{false};  ///< receives states and events, publishes nothing
  bool tracker{false};   ///< publishes poses of the palm instead of proxies; not with `observer`
  std::string client_name{"haptic client"};  ///< shown to other clients; 1 to 64 bytes of UTF-8
  /// How often you will publish, Hz, 1 to 2000. Samples that come more than twice as fast do not
  /// count as fresh. Not used by an observer.
  double nominal_rate_hz{60.0};
  /// A server that asks for certificates may limit the priority of each.
  Priority priority{Priority::kPrimary};
  double state_rate_hz{0.0};  ///< how many states per second to receive; 0: one per tick
  /// Sends each held proxy as contacts, one per block of `blocks`: ContactEstimator in
  /// estimator.hpp, with the state that you were last given. Only after a first free proxy: one
  /// that is held from the start does not say on which side of an object the probe is.
  bool derive_planes{false};
  std::vector<Block> blocks{};  ///< empty: all coordinates are one block
  /// Ages of a sample at which it stops being fresh, its force begins to fade, and its force is
  /// zero. Each can shorten the scene's limit, not lengthen it.
  std::optional<std::chrono::nanoseconds> fresh_end{}, hold_end{}, fade_end{};
  Carriers carriers{Carriers::kAutomatic};
  Reconnect reconnect{Reconnect::kNever};
  /// Asks for force again after it was lost because samples came too late or the stream was lost.
  /// Never after a fault: clearing an emergency stop must not start a motor.
  bool re_engage{false};
  std::chrono::milliseconds timeout{5000};  ///< of every call that waits for an answer
  std::function<void(const DeviceState&)> on_state{};
  std::function<void(const Event&)> on_event{};
  /// Called when the stream is lost. `will_retry`: the session reconnects; if it gives that up
  /// later, this is called once more with false.
  std::function<void(const ClientError&, bool will_retry)> on_disconnect{};
};

/// Calls that wait for an answer throw ClientError.
class Session {
 public:
  /// Calls close(). Must not run in a callback of this session.
  virtual ~Session() = default;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Sends where the proxy is now. Never waits for the network, never throws. The newest sample
  /// wins: one that could not be sent yet is replaced and counted; without a stream it is dropped.
  /// If `proxy.device_seq_used` is 0, the library takes the proxy to be computed from the last
  /// state that a call or a callback gave you.
  virtual void publish(Proxy proxy) noexcept = 0;
  /// The same for the poses of a tracker.
  virtual void publish_pose(const Pose& pose) noexcept = 0;

  /// The newest state; its `seq` is 0 before the first one and after the session started again.
  [[nodiscard]] virtual DeviceState state() const = 0;
  /// Waits for a state newer than the last one that this call returned. Throws kTimeout, kClosed,
  /// and kInvalidArgument if called in on_state. Without a timeout: SessionOptions::timeout.
  [[nodiscard]] virtual DeviceState wait_for_state(
      std::optional<std::chrono::milliseconds> timeout = {}) = 0;

  /// Asks for force once. Throws kNotReady and says what is missing.
  virtual void engage() = 0;
  /// Asks for force in the background, every 50 ms, until the server agrees. Gives up on a refusal
  /// that waiting does not change, on a fault, and, without `re_engage`, when force is lost.
  /// Calling it again is harmless.
  virtual void engage_when_ready() = 0;
  /// Why engage_when_ready() has no force yet, or why it gave up; empty after the server agreed.
  [[nodiscard]] virtual std::optional<ClientError> engage_refusal() const = 0;
  /// Gives force up; it fades out. Also ends engage_when_ready(). Without a stream it returns at
  /// once.
  virtual void release() = 0;
  virtual AppliedSettings update(const Settings& settings) = 0;

  /// True while the session has a stream. False too while a lost stream is opened again
  /// (Reconnect::kWithBackoff).
  [[nodiscard]] virtual bool connected() const = 0;
  /// Figures of the UDP path; empty if the session has none.
  [[nodiscard]] virtual std::optional<UdpLink> udp_link() const = 0;
  /// From publish() to the arrival of the first state that used the sample, by whatever carrier:
  /// rises at once, falls slowly. 0: not known yet. For contact_horizon() in contact.hpp.
  [[nodiscard]] virtual std::chrono::nanoseconds round_trip() const = 0;
  [[nodiscard]] virtual std::uint32_t lease_epoch() const = 0;  ///< rises with every lease; 0: none
  [[nodiscard]] virtual PublishStatistics statistics() const = 0;
  [[nodiscard]] virtual const DeviceInfo& device() const = 0;  ///< as it was at the first opening

  /// Ends the session; the server lets force fade out. No callback runs after close() returned;
  /// called in a callback, it does not wait for that one. A session that reconnects gives the
  /// server up to 500 ms to hear that it ends; other sessions do not wait for the server.
  virtual void close() = 0;

 protected:
  Session() = default;
};

}  // namespace haptic::client
