#pragma once
/// A rig that ticks on the steady clock, with the service on real sockets in the same process.

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/base/steady_now.hpp"
#include "server/front/server.hpp"
#include "tests/server/support/device_rig.hpp"
#include "tests/support/within.hpp"

namespace haptic::test {

/// The rig's settings with a long hold, so that a busy machine does not end the force in a test of
/// requests.
inline core::PipelineConfig patient_config() {
  core::PipelineConfig config = rig_config();
  config.scene.staleness.hold_end = 5s;
  config.scene.staleness.fade_end = 6s;
  return config;
}

class LiveServer {
 public:
  explicit LiveServer(server::ServiceConfig config = {{"127.0.0.1:0"}},
                      core::PipelineConfig pipeline = patient_config(),
                      server::SessionRules rules = {})
      : rig(std::move(pipeline), rules, server::steady_now(), config.max_sessions),
        rpc(std::move(config), *rig.owner, [] {
          server::ServerFacts facts{.version = "1.2.3", .scene = "test"};
          facts.realtime.grade = "best-effort";
          facts.loop.ticks = 42;
          return facts;
        }) {
    // Three ticks first, so that a client finds a device that is open.
    rig.tick(3);
    rpc.start();
    loop_ = std::thread([this] { run(); });
  }

  ~LiveServer() {
    rpc.shutdown(5s);
    running_ = false;
    loop_.join();
  }

  [[nodiscard]] std::string address() const { return rpc.bound_addresses().front(); }
  [[nodiscard]] std::shared_ptr<grpc::Channel> channel() const {
    return grpc::CreateChannel(address(), grpc::InsecureChannelCredentials());
  }
  /// The loop stops ticking while this is set; nothing else knows.
  std::atomic<bool> hung{false};

  DeviceRig rig;
  server::FrontServer rpc;

 private:
  void run() {
    while (running_) {
      std::this_thread::sleep_until(std::chrono::steady_clock::time_point(
          std::chrono::nanoseconds((rig.now + DeviceRig::kTick).time_since_epoch())));
      const core::TimePoint now = server::steady_now();
      if (hung) {
        std::this_thread::sleep_for(1ms);
        continue;
      }
      // Late ticks are skipped, as the real loop does.
      if (now - rig.now > 2 * DeviceRig::kTick) rig.now = now - DeviceRig::kTick;
      rig.tick();
    }
  }

  std::atomic<bool> running_{true};
  std::thread loop_;
};

}  // namespace haptic::test
