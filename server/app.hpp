#pragma once
/// The composition root: the one place that knows both halves, the owner of the devices and the
/// front.
///
/// | thread    | what it owns                                     | how it stops                 |
/// |-----------|--------------------------------------------------|------------------------------|
/// | main      | the App; waits for signals                       | App::stop() returned         |
/// | loop      | units: device read and write, pipeline           | every unit CLOSING, or 2.5 s |
/// | board I/O | port and protocol of a board, one thread each    | Device::close(), 100 ms      |
/// | telemetry | reading end of the rings; leases' clock, events, | Telemetry::stop(), after a   |
/// |           | states to streams, recorder, log                 | last drain                   |
/// | udp       | the UDP path's socket: samples in, challenges;   | UdpPort::stop(), by shutdown |
/// |           | only if the scene has udp_listen                 |                              |
/// | metrics   | scrapes; only if the scene wants metrics         | ~MetricsPort, at once        |
/// | connec-   | accepts connections, counts their bytes          | RpcServer::shutdown(), 1 s   |
/// | tions     |                                                  |                              |
/// | gRPC's    | calls; they enter the owner under its lock       | RpcServer::shutdown(), 1 s   |
///
/// All but main block every signal (gRPC's inherit SIGTERM, SIGINT and SIGHUP blocked from main).

#include <memory>
#include <string>
#include <vector>

#include "server/crossing/server_facts.hpp"
#include "server/owner/event_log.hpp"
#include "server/owner/owner.hpp"
#include "server/owner/recorder.hpp"
#include "server/rt/loop.hpp"
#include "server/rt/realtime.hpp"
#include "server/scene/scene.hpp"

namespace haptic::server {

class MetricsPort;
class RpcServer;
class TickMetrics;

struct AppOptions {
  RealtimeMode realtime{RealtimeMode::kTry};
  bool insecure_lab{false};  ///< plain text on any address (RpcConfig)
};

class App {
 public:
  App(Scene scene, AppOptions options);
  /// stop().
  ~App();
  App(const App&) = delete;
  App& operator=(const App&) = delete;

  /// Once. Gets the real-time grant, opens the devices, binds the addresses, starts the loop:
  /// nothing ticks before all of it stands. Throws SceneError, DeviceError, RealtimeError,
  /// TransportError; what was started by then is stopped.
  void start();
  /// SIGTERM of proto/README.md#states-of-a-device: force fades out, devices are disarmed,
  /// telemetry drained, calls ended; less than 5 s. Idempotent.
  void stop();

  /// As bound, ports filled in; empty unless running.
  [[nodiscard]] std::vector<std::string> addresses() const;
  /// The metrics'; 0 if there are none.
  [[nodiscard]] std::uint16_t metrics_port() const;
  [[nodiscard]] const RealtimeGrant& realtime() const noexcept { return realtime_; }
  /// Any thread, between start() and stop().
  [[nodiscard]] LoopFacts loop_facts() const;
  [[nodiscard]] const Owner& owner() const { return *owner_; }
  [[nodiscard]] const DeviceUnit& unit(std::size_t device) const { return *units_.at(device); }

 private:
  void open_devices();
  /// The samples of the board that paces the loop; null: the timer does.
  [[nodiscard]] hw::SampleSignal* pacing_samples();
  void listen_to_devices();
  void listen_for_scrapes();
  [[nodiscard]] ServerFacts facts() const;

  const Scene scene_;
  const AppOptions options_;
  core::TimePoint started_{};
  RealtimeGrant realtime_{};
  // Destroyed from the last to the first: each uses those above it.
  std::vector<std::unique_ptr<DeviceUnit>> units_{};
  std::vector<std::unique_ptr<Recorder>> recorders_{};
  std::unique_ptr<Telemetry> telemetry_{};
  std::unique_ptr<Owner> owner_{};
  std::unique_ptr<RpcServer> rpc_{};
  std::unique_ptr<Loop> loop_{};
  std::shared_ptr<EventLog> event_log_{};
  std::shared_ptr<TickMetrics> tick_metrics_{};  ///< null if there are no metrics
  std::unique_ptr<MetricsPort> metrics_{};
};

/// The project's version.
[[nodiscard]] const char* version() noexcept;

}  // namespace haptic::server
