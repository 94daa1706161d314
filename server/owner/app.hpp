#pragma once
/// The owner's composition: devices, loop, sessions, recorder, and the front that is started for
/// them.
///
/// | thread     | what it owns                                    | how it stops                 |
/// |------------|-------------------------------------------------|------------------------------|
/// | main       | the App; waits for signals                      | App::stop() returned         |
/// | loop       | units: device read and write, pipeline          | every unit CLOSING, or 2.5 s |
/// | board I/O  | port and protocol of a board, one thread each   | Device::close(), 100 ms      |
/// | telemetry  | reading end of the rings; leases' clock,        | Telemetry::stop(), after a   |
/// |            | events, states to the front, recorder, log      | last drain                   |
/// | front link | requests, samples, fronts' lives                | FrontLink::stop(), 1.5 s     |
/// | link watch | ends the front if the front link does not turn  | after the front link         |
/// | local      | local control socket: stops, clears, health     | after the front link         |
/// | control    |                                                 |                              |
///
/// All but main block every signal. The front's threads: server/front/server.hpp.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/crossing/server_facts.hpp"
#include "server/owner/loop/loop.hpp"
#include "server/owner/loop/realtime.hpp"
#include "server/owner/rights/owner.hpp"
#include "server/owner/scene/scene.hpp"
#include "server/owner/telemetry/event_log.hpp"
#include "server/owner/telemetry/recorder.hpp"

namespace haptic::server {

class TickMetrics;

struct AppOptions {
  RealtimeMode realtime{RealtimeMode::kTry};
  bool insecure_lab{false};  ///< for the front: plain text on any address (FrontConfig)
  std::string log_level{"info"}, log_format{"text"};  ///< for the front
};

/// The part that faces the network, as the App starts and stops it.
class FrontRunner {
 public:
  virtual ~FrontRunner() = default;
  /// Serves when it returns. Throws TransportError.
  virtual void start() = 0;
  /// Ends streams and calls. Idempotent.
  virtual void stop() = 0;
  /// A new one takes its place.
  virtual void restart() {}
  /// The addresses that were bound, ports filled in.
  [[nodiscard]] virtual std::vector<std::string> addresses() const = 0;
};

class App {
 public:
  using MakeFront = std::function<std::unique_ptr<FrontRunner>(App& app)>;

  /// `make_front`: called by start() when the owner's parts exist.
  App(Scene scene, AppOptions options, MakeFront make_front);
  /// stop().
  ~App();
  App(const App&) = delete;
  App& operator=(const App&) = delete;

  /// Once. Gets the real-time grant, opens the devices, binds the addresses, starts the front and
  /// the loop: nothing ticks before all of it stands. Throws SceneError, DeviceError,
  /// RealtimeError, TransportError; what was started by then is stopped.
  void start();
  /// SIGTERM of proto/README.md#states-of-a-device: force fades out, devices are disarmed,
  /// telemetry drained, calls ended; less than 5 s. Idempotent.
  void stop();

  /// The addresses that were bound, ports filled in; empty unless running.
  [[nodiscard]] std::vector<std::string> addresses() const;
  void restart_front() { front_->restart(); }
  [[nodiscard]] const RealtimeGrant& realtime() const noexcept { return realtime_; }
  /// Any thread, between start() and stop().
  [[nodiscard]] LoopFacts loop_facts() const;
  [[nodiscard]] ServerFacts facts() const;
  [[nodiscard]] Owner& owner() const { return *owner_; }
  [[nodiscard]] const Scene& scene() const noexcept { return scene_; }
  [[nodiscard]] const AppOptions& options() const noexcept { return options_; }
  /// Null if the scene has no metrics.
  [[nodiscard]] std::shared_ptr<const TickMetrics> tick_metrics() const { return tick_metrics_; }
  [[nodiscard]] const DeviceUnit& unit(std::size_t device) const { return *units_.at(device); }

 private:
  void open_devices();
  /// The samples of the board that paces the loop; null: the timer does.
  [[nodiscard]] hw::SampleSignal* pacing_samples();
  void listen_to_devices();

  const Scene scene_;
  const AppOptions options_;
  const MakeFront make_front_;
  core::TimePoint started_{};
  RealtimeGrant realtime_{};
  // Destroyed from the last to the first: each uses those above it.
  std::vector<std::unique_ptr<DeviceUnit>> units_{};
  std::vector<std::unique_ptr<Recorder>> recorders_{};
  std::unique_ptr<Telemetry> telemetry_{};
  std::unique_ptr<Owner> owner_{};
  std::unique_ptr<Loop> loop_{};
  std::shared_ptr<EventLog> event_log_{};
  std::shared_ptr<TickMetrics> tick_metrics_{};
  std::unique_ptr<FrontRunner> front_{};
};

}  // namespace haptic::server
