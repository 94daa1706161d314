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
#include "server/owner/link/hand_over.hpp"
#include "tests/server/support/device_rig.hpp"
#include "tests/server/support/port_of.hpp"
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
  explicit LiveServer(const server::ServerScene& scene = {{"127.0.0.1:0"}},
                      core::PipelineConfig pipeline = patient_config(),
                      server::SessionRules rules = {}, server::ServiceLimits limits = {})
      : rig(std::move(pipeline), rules, server::steady_now(), scene.max_sessions),
        hand_over(server::front_config(scene, false), scene, "/no/page"),
        rpc(hand_over.start(), *rig.owner, {[] {
              server::ServerFacts facts{.version = "1.2.3", .scene = "test"};
              facts.realtime.grade = "best-effort";
              facts.loop.ticks = 42;
              return facts;
            }},
            std::move(limits)) {
    // Three ticks first, so that a client finds a device that is open.
    rig.tick(3);
    rpc.start();
    loop_ = std::thread([this] { run(); });
  }

  ~LiveServer() {
    rpc.stop(5s);
    running_ = false;
    loop_.join();
  }

  [[nodiscard]] std::string address() const { return hand_over.addresses().front(); }
  [[nodiscard]] std::uint16_t udp_port() const { return port_of(hand_over.config().udp_listen); }
  [[nodiscard]] std::shared_ptr<grpc::Channel> channel() const {
    return grpc::CreateChannel(address(), grpc::InsecureChannelCredentials());
  }
  /// The loop stops ticking while this is set; nothing else knows.
  std::atomic<bool> hung{false};

  DeviceRig rig;
  server::HandOver hand_over;
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
