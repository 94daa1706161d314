// The contract of proto/README.md#staleness-and-gain over real sockets: pressing, then the client
// is killed, or paused; a client that is silent beyond its lease and goes on.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <functional>
#include <mutex>
#include <thread>

#include "haptic/client/client.hpp"
#include "tests/server/support/app.hpp"
#include "tests/system/process.hpp"

namespace haptic {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A finger at rest at 30, 30 degrees, and its states.
class Served : public ::testing::Test {
 protected:
  void SetUp() override {
    app_.start();
    connection_ = std::make_unique<client::Connection>(app_.addresses().front());
    watch_ = connection_->watch("finger", 1000.0, [this](const client::DeviceState& state) {
      const std::lock_guard lock(mutex_);
      states_.push_back(state);
    });
  }

  /// Waits, generously, for a state that holds; `meanwhile` every 5 ms.
  template <typename Rule>
  bool eventually(
      Rule rule, const std::function<void()>& meanwhile = [] {}) {
    const auto give_up = std::chrono::steady_clock::now() + seconds(30);
    while (std::chrono::steady_clock::now() < give_up) {
      {
        const std::lock_guard lock(mutex_);
        if (!states_.empty() && rule(states_.back())) return true;
      }
      meanwhile();
      std::this_thread::sleep_for(milliseconds(5));
    }
    return false;
  }

  std::vector<client::DeviceState> states() {
    const std::lock_guard lock(mutex_);
    return states_;
  }

  test::App app_{server::load_scene(
                     std::string(HAPTIC_SOURCE_DIR) + "/server/scenes/finger_constant.textproto",
                     {"server.listen[0]=127.0.0.1:0", "loop.late_bucket_full=1000000",
                      "loop.loop_late_fault={seconds: 5}"}),
                 {server::RealtimeMode::kTry}};
  std::mutex mutex_;
  std::vector<client::DeviceState> states_;
  std::unique_ptr<client::Connection> connection_;
  std::unique_ptr<client::Watch> watch_;
};

/// A virtual wall that it presses against from another process.
class Pressing : public Served {
 protected:
  void SetUp() override {
    Served::SetUp();
    wall_ = std::make_unique<test::Process>(
        std::string(HAPTIC_BINARY_DIR) + "/client/haptic-example-virtual-wall",
        std::vector<std::string>{"--server", app_.addresses().front(), "--stop", "0.3"});
    ASSERT_TRUE(eventually([](const client::DeviceState& s) {
      return s.state == client::Lifecycle::kEngaged && std::abs(s.tau_elastic.at(0)) > 0.5;
    })) << "the wall is never pressed";
  }

  /// In every state that was seen: silence has an end, recovery is a ramp. The silence is timed by
  /// the server's clock from the last sample that it used, so that it goes on where the lease
  /// ended.
  void expect_the_contract() {
    std::this_thread::sleep_for(milliseconds(400));
    const auto seen = states();
    std::int64_t born = seen.front().server_time_ns;  // of the newest sample used so far
    std::uint64_t newest = 0;
    int silent = 0;
    for (std::size_t i = 1; i < seen.size(); ++i) {
      const client::DeviceState& s = seen[i];
      if (s.proxy_seq_used > newest) {
        newest = s.proxy_seq_used;
        born = s.server_time_ns - std::chrono::nanoseconds(s.proxy_age).count();
      }
      if (s.server_time_ns - born >= std::chrono::nanoseconds(milliseconds(200)).count()) {
        ASSERT_EQ(s.tau_elastic.at(0), 0.0) << (s.server_time_ns - born) / 1000 << " us of silence";
        silent += newest > 0 ? 1 : 0;
      }
      const double dt = static_cast<double>(s.server_time_ns - seen[i - 1].server_time_ns) * 1e-9;
      ASSERT_LE(s.gain - seen[i - 1].gain, dt / 0.2 + 1e-9) << "gain rose by a step";
    }
    EXPECT_GT(silent, 0) << "no state of a silence longer than 200 ms was seen";
  }

  std::unique_ptr<test::Process> wall_;
};

client::SessionOptions controller(const char* name) {
  return {.client_name = name, .nominal_rate_hz = 100};
}

TEST_F(Pressing, KilledClientLosesForceAndLease) {
  wall_->signal(SIGKILL);
  wall_->wait();
  ASSERT_TRUE(eventually([](const client::DeviceState& s) {
    return s.tau_elastic.at(0) == 0.0 && s.state == client::Lifecycle::kIdle;
  }));
  expect_the_contract();
  const auto next = connection_->open(controller("the next one"));
  EXPECT_TRUE(next->connected());
}

// The kernel goes by the smallest latency that any program asks for; it answers in us.
TEST_F(Pressing, IdleProcessorsStayAwake) {
  std::fstream latency("/dev/cpu_dma_latency", std::ios::in | std::ios::out | std::ios::binary);
  if (!latency) GTEST_SKIP() << "this host does not let its processors be kept awake";
  std::int32_t longest_us = -1;
  latency.read(reinterpret_cast<char*>(&longest_us), sizeof longest_us);
  EXPECT_EQ(longest_us, 0);
}

TEST_F(Pressing, PausedClientLosesForceThenLease) {
  try {
    static_cast<void>(connection_->open(controller("impatient")));
    FAIL() << "two controllers";
  } catch (const client::ClientError& error) {
    EXPECT_EQ(error.reason(), client::ErrorReason::kLeaseHeld);
    EXPECT_NE(std::string(error.what()).find("virtual wall"), std::string::npos) << error.what();
  }
  wall_->signal(SIGSTOP);
  ASSERT_TRUE(eventually([](const client::DeviceState& s) {
    return s.state == client::Lifecycle::kArmed && s.tau_elastic.at(0) == 0.0;
  }));
  ASSERT_TRUE(eventually([](const client::DeviceState& s) {
    return s.state == client::Lifecycle::kIdle && s.tau_a.at(0) == 0.0;
  })) << "the lease must end by its clock";
  expect_the_contract();
  EXPECT_TRUE(connection_->open(controller("the next one"))->connected());
  wall_->signal(SIGCONT);
}

TEST_F(Pressing, BriefPauseComesBackAsRamp) {
  wall_->signal(SIGSTOP);
  ASSERT_TRUE(eventually([](const client::DeviceState& s) {
    return s.state == client::Lifecycle::kArmed && s.tau_elastic.at(0) == 0.0 &&
           s.proxy_age > milliseconds(300);
  }));
  wall_->signal(SIGCONT);
  EXPECT_TRUE(eventually([](const client::DeviceState& s) {
    return s.state == client::Lifecycle::kEngaged && std::abs(s.tau_elastic.at(0)) > 0.5;
  })) << "the wall asks for force again by itself (re_engage)";
  expect_the_contract();
}

TEST_F(Served, ForceReturnsUnderTheNextLease) {
  client::SessionOptions options = controller("often silent");
  options.reconnect = client::Reconnect::kWithBackoff;
  options.re_engage = true;
  const auto session = connection_->open(options);
  session->engage_when_ready();
  const auto speak = [&] {
    const client::DeviceState state = session->state();
    const bool force = state.gain > 0.0;  // which begins with a free proxy
    session->publish(force ? client::Proxy::held(state.x_probe) : client::Proxy::free());
  };
  const auto engaged = [](const client::DeviceState& s) {
    return s.state == client::Lifecycle::kEngaged;
  };
  ASSERT_TRUE(eventually(engaged, speak));
  ASSERT_EQ(session->lease_epoch(), 1U);

  ASSERT_TRUE(eventually([](const client::DeviceState& s) {
    return s.state == client::Lifecycle::kIdle;
  })) << "the lease must end by its clock";
  EXPECT_EQ(session->lease_epoch(), 1U) << "a silent client took the device back";
  // Waits as long as a client that does not know yet may take: its asking must survive the
  // refusals.
  std::this_thread::sleep_for(milliseconds(300));

  ASSERT_TRUE(eventually(
      [&](const client::DeviceState& s) { return session->lease_epoch() > 1 && engaged(s); },
      speak))
      << (session->engage_refusal() ? session->engage_refusal()->what() : "nobody asks for force");
  session->close();
}

}  // namespace
}  // namespace haptic
