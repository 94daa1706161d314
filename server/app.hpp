#pragma once
/// The composition root: the one place that knows everything.
///
/// | thread       | owns                                        | how it stops |
/// |--------------|---------------------------------------------|---------------------------------------|
/// | main         | the App, signals                            | stop() returns | | haptic-rt    |
/// loop, devices' read and write, pipelines    | every unit CLOSING, or 3 s            | |
/// haptic-drain | rings' reading end, events, recorder, log   | Telemetry::stop() | | gRPC's |
/// calls; they post to mailboxes under a mutex | RpcServer::shutdown(), 1 s            |

#include <memory>
#include <string>
#include <vector>

#include "server/rt/loop.hpp"
#include "server/rt/realtime.hpp"
#include "server/scene/scene.hpp"
#include "server/session/device_sessions.hpp"

namespace haptic::server {

struct AppOptions {
  RealtimeMode realtime{RealtimeMode::kTry};
};

class App {
 public:
  App(Scene scene, AppOptions options);
  ~App();
  App(const App&) = delete;
  App& operator=(const App&) = delete;

  /// Opens the devices, starts the loop, serves. Throws SceneError, DeviceError, RealtimeError,
  /// TransportError; what was started by then is stopped.
  void start();
  /// SIGTERM of WIRE 4: force fades out, devices are disarmed, telemetry drained, calls ended; less
  /// than 5 s. Idempotent.
  void stop();

  [[nodiscard]] std::vector<std::string> addresses() const;
  [[nodiscard]] const RealtimeFacts& realtime() const noexcept { return realtime_; }
  [[nodiscard]] LoopFacts loop_facts() const;
  [[nodiscard]] DeviceSessions& sessions(std::size_t device) { return *sessions_.at(device); }

 private:
  class Rpc;
  void open_devices();
  [[nodiscard]] ServerFacts facts() const;

  const Scene scene_;
  const AppOptions options_;
  core::TimePoint started_{};
  RealtimeFacts realtime_{};
  std::vector<std::unique_ptr<DeviceUnit>> units_{};
  std::unique_ptr<Telemetry> telemetry_{};
  std::vector<std::unique_ptr<RecordListener>> listeners_{};
  std::vector<std::unique_ptr<DeviceSessions>> sessions_{};
  std::unique_ptr<Rpc> rpc_{};
  std::unique_ptr<Loop> loop_{};
  bool running_{false};
};

/// "0.1.0": the project's version.
[[nodiscard]] const char* version() noexcept;

}  // namespace haptic::server
