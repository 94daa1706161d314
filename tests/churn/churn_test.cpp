/// Clients come and go over every carrier, mainly for the thread sanitizer. Three seconds by
/// default; HAPTIC_CHURN_SECONDS sets another length (tests/churn/run.sh).

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <thread>

#include "haptic/client/client.hpp"
#include "server/owner/scene/scene.hpp"
#include "tests/server/support/app.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;
using Steady = std::chrono::steady_clock;

std::chrono::seconds how_long() {
  const char* text = std::getenv("HAPTIC_CHURN_SECONDS");
  return std::chrono::seconds(text == nullptr ? 3 : std::max(1, std::atoi(text)));
}

/// Accepts late ticks: an instrumented program on a busy machine has many.
server::Scene patient_scene(const std::string& unix_address) {
  server::Scene scene =
      server::load_scene(HAPTIC_SOURCE_DIR "/server/scenes/finger_constant.textproto");
  scene.server.listen = {"127.0.0.1:0", unix_address};
  scene.server.udp_listen = "127.0.0.1:0";
  scene.loop.loop_late_fault = 10s;
  return scene;
}

class Churn {
 public:
  explicit Churn(test::App& app) : tcp_(app.addresses().at(0)), unix_(app.addresses().at(1)) {}

  /// Opens a session, sends for a while, asks for force, leaves; over and over.
  void control(const std::string& address, client::Carriers carriers) {
    const auto once = [&] {
      client::Connection connection(address);
      client::SessionOptions options;
      options.client_name = "churn";
      options.nominal_rate_hz = 200.0;
      options.carriers = carriers;
      options.on_state = [this](const client::DeviceState&) { ++states; };
      options.on_event = [this](const client::Event&) { ++events; };
      const auto session = connection.open(options);
      ++opened;
      session->engage_when_ready();
      for (int i = 0; i < 80 && running; ++i) {
        const client::DeviceState state = session->state();
        const bool force = state.gain > 0.0;  // which begins with a free proxy
        session->publish(force ? client::Proxy::held(state.x_probe) : client::Proxy::free());
        if (state.carrier == client::Carrier::kUdp) ++by_udp;
        std::this_thread::sleep_for(5ms);
      }
    };
    repeat(once);
  }
  void watch() {
    repeat([&] {
      client::Connection connection(unix_);
      const auto watch =
          connection.watch("finger", 500.0, [this](const client::DeviceState&) { ++states; });
      std::this_thread::sleep_for(50ms);
      static_cast<void>(connection.devices());
      static_cast<void>(connection.server_info());
    });
  }
  void observe() {
    repeat([&] {
      client::Connection connection(tcp_);
      client::SessionOptions options;
      options.observer = true;
      options.client_name = "observer";
      options.on_state = [this](const client::DeviceState&) { ++states; };
      const auto session = connection.open(options);
      std::this_thread::sleep_for(80ms);
    });
  }
  void stop_and_clear() {
    repeat([&] {
      client::Connection connection(tcp_);
      connection.emergency_stop();
      std::this_thread::sleep_for(20ms);
      connection.clear_fault();
      std::this_thread::sleep_for(500ms);
    });
  }

  const std::string tcp_, unix_;
  std::atomic<bool> running{true};
  std::atomic<std::uint64_t> opened{0}, states{0}, events{0}, by_udp{0};

 private:
  /// Refusals (the lease is held, the session is gone) are expected.
  template <typename Work>
  void repeat(const Work& work) {
    while (running) {
      try {
        work();
      } catch (const client::ClientError&) {
        std::this_thread::sleep_for(5ms);
      }
    }
  }
};

TEST(Churn, EveryCarrierSurvivesComingAndGoing) {
  const std::string address = "unix:/tmp/haptic-churn-" + std::to_string(getpid());
  test::App app(patient_scene(address), {server::RealtimeMode::kOff});
  app.start();
  Churn churn(app);
  std::vector<std::thread> threads;
  threads.emplace_back([&] { churn.control(churn.tcp_, client::Carriers::kAutomatic); });
  threads.emplace_back([&] { churn.control(churn.tcp_, client::Carriers::kGrpcOnly); });
  threads.emplace_back([&] { churn.control(churn.unix_, client::Carriers::kAutomatic); });
  threads.emplace_back([&] { churn.watch(); });
  threads.emplace_back([&] { churn.observe(); });
  threads.emplace_back([&] { churn.stop_and_clear(); });
  std::this_thread::sleep_for(how_long());
  churn.running = false;
  for (std::thread& thread : threads) thread.join();
  app.stop();
  EXPECT_GT(churn.opened, 1U);
  EXPECT_GT(churn.states, 100U);
  EXPECT_GT(churn.by_udp, 0U);
}

}  // namespace
}  // namespace haptic::test
