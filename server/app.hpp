#pragma once
/// The composition root: the one place that knows everything.
///
/// | thread    | what it owns                                    | how it stops                 |
/// |-----------|-------------------------------------------------|------------------------------|
/// | main      | the App; waits for signals                      | App::stop() returned         |
/// | loop      | units: device read and write, pipeline          | every unit CLOSING, or 2.5 s |
/// | board I/O | port and protocol of a board, one thread each   | Device::close(), 100 ms      |
/// | telemetry | reading end of the rings; lease clock, events,  | Telemetry::stop(), after a   |
/// |           | states to streams, recorder, log                | last drain                   |
/// | udp       | the UDP path's socket: samples in, challenges;  | UdpPort::stop(), by shutdown |
/// |           | there only where the scene has udp_listen       |                              |
/// | metrics   | scrapes, one at a time, and one that accepts    | MetricsPort::stop(), when    |
/// |           | them; there only where the scene wants metrics  | the scrape under way is done |
/// | gRPC's    | calls; they post to mailboxes under a mutex     | RpcServer::shutdown(), 1 s   |
///
/// All but main block every signal (gRPC's inherit SIGTERM, SIGINT and SIGHUP blocked from main).

#include <memory>
#include <string>
#include <vector>

#include "server/rt/loop.hpp"
#include "server/rt/realtime.hpp"
#include "server/scene/scene.hpp"
#include "server/session/device_sessions.hpp"

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
  /// Of the metrics; 0 where there are none.
  [[nodiscard]] std::uint16_t metrics_port() const;
  [[nodiscard]] const RealtimeGrant& realtime() const noexcept { return realtime_; }
  /// Any thread, between start() and stop().
  [[nodiscard]] LoopFacts loop_facts() const;
  [[nodiscard]] DeviceSessions& sessions(std::size_t device) { return *sessions_.at(device); }

 private:
  void open_devices();
  /// Of the board that paces the loop; null: the timer does.
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
  std::vector<std::unique_ptr<RecordListener>> listeners_{};
  std::unique_ptr<Telemetry> telemetry_{};
  std::vector<std::unique_ptr<DeviceSessions>> sessions_{};
  std::unique_ptr<RpcServer> rpc_{};
  std::unique_ptr<Loop> loop_{};
  std::vector<TickMetrics*> tick_metrics_{};  ///< of listeners_; empty where there are no metrics
  std::unique_ptr<MetricsPort> metrics_{};
};

/// The project's version.
[[nodiscard]] const char* version() noexcept;

}  // namespace haptic::server
