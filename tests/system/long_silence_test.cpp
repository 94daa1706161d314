// A client that is silent beyond its lease and goes on: controller again, and with force where it
// asked to.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "haptic/client/client.hpp"
#include "server/app.hpp"

namespace haptic {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Waits, generously, for a condition; `meanwhile` every 5 ms.
template <typename Condition, typename Work>
bool eventually(Condition condition, Work meanwhile) {
  const auto give_up = std::chrono::steady_clock::now() + seconds(30);
  while (std::chrono::steady_clock::now() < give_up) {
    if (condition()) return true;
    meanwhile();
    std::this_thread::sleep_for(milliseconds(5));
  }
  return false;
}

TEST(LongSilence, ForceReturnsUnderTheNextLease) {
  server::App app(server::load_scene(
                      std::string(HAPTIC_SOURCE_DIR) + "/server/scenes/finger_constant.textproto",
                      {"server.listen[0]=127.0.0.1:0", "loop.late_bucket_full=1000000",
                       "loop.loop_late_fault={seconds: 5}"}),
                  {server::RealtimeMode::kTry});
  app.start();
  client::Connection connection(app.addresses().front());
  client::SessionOptions options;
  options.client_name = "often silent";
  options.nominal_rate_hz = 100;
  options.reconnect = client::Reconnect::kWithBackoff;
  options.re_engage = true;
  const auto session = connection.open(options);
  session->engage_when_ready();
  const auto speak = [&] {
    const client::DeviceState state = session->state();
    if (!state.x_probe.empty()) session->publish(client::Proxy::held(state.x_probe));
  };
  const auto engaged = [&] { return session->state().state == client::Lifecycle::kEngaged; };
  ASSERT_TRUE(eventually(engaged, speak));
  ASSERT_EQ(session->lease_epoch(), 1U);

  std::atomic<bool> idle{false};
  const auto watch = connection.watch("finger", 100.0, [&](const client::DeviceState& state) {
    if (state.state == client::Lifecycle::kIdle) idle = true;
  });
  ASSERT_TRUE(eventually([&] { return idle.load(); }, [] {})) << "the lease must end by its clock";
  EXPECT_EQ(session->lease_epoch(), 1U) << "a silent client took the device back";
  // As long as a client may take that does not know yet: its asking must survive the refusals.
  std::this_thread::sleep_for(milliseconds(300));

  ASSERT_TRUE(eventually([&] { return session->lease_epoch() > 1 && engaged(); }, speak))
      << (session->engage_refusal() ? session->engage_refusal()->what() : "nobody asks for force");
  session->close();
  app.stop();
}

}  // namespace
}  // namespace haptic
