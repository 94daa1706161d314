// The contract of proto/README.md#staleness-and-gain over real sockets: pressing, then the client
// is killed or stopped.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <mutex>
#include <thread>

#include "haptic/client/client.hpp"
#include "tests/server/support/app.hpp"
#include "tests/support/within.hpp"
#include "tests/system/process.hpp"

namespace haptic {
namespace {

using std::chrono::milliseconds;

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

  /// The newest state obeys `rule` in the end.
  template <typename Rule>
  bool eventually(Rule rule) {
    return test::eventually([&] {
      const std::lock_guard lock(mutex_);
      return !states_.empty() && rule(states_.back());
    });
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

/// A virtual wall that another process presses against.
class Pressing : public Served {
 protected:
  void SetUp() override {
    Served::SetUp();
    wall_ = std::make_unique<test::Process>(
        HAPTIC_BINARY_DIR "/client/haptic-example-virtual-wall",
        std::vector<std::string>{"--server", app_.addresses().front(), "--stop", "0.3"});
    ASSERT_TRUE(engaged()) << "the wall is never pressed";
  }
  [[nodiscard]] bool engaged() {
    return eventually([](const client::DeviceState& s) {
      return s.state == client::Lifecycle::kEngaged && std::abs(s.tau_elastic.at(0)) > 0.5;
    });
  }
  std::unique_ptr<test::Process> wall_;
};

/// The wall's process is ended by the parameter, a signal: killed, its connection ends; stopped, it
/// only falls silent.
class LostClient : public Pressing, public ::testing::WithParamInterface<int> {};

client::SessionOptions controller(const char* name) {
  return {.client_name = name, .nominal_rate_hz = 100};
}

TEST_P(LostClient, LosesForceThenLease) {
  wall_->signal(GetParam());
  ASSERT_TRUE(eventually([](const client::DeviceState& s) {
    return s.state == client::Lifecycle::kIdle && s.tau_a.at(0) == 0.0;
  })) << "the lease must end";
  std::this_thread::sleep_for(milliseconds(400));
  // The silence is timed by the server's clock from the last sample that it used, so that it goes
  // on where the lease ended.
  constexpr std::int64_t kSilence = 200'000'000;  // ns
  std::int64_t born = 0;
  int silent = 0;
  for (const client::DeviceState& s : states()) {
    if (s.proxy_seq_used > 0) {
      born = s.server_time_ns - std::chrono::nanoseconds(s.proxy_age).count();
    }
    if (born == 0 || s.server_time_ns - born < kSilence) continue;
    ASSERT_EQ(s.tau_elastic.at(0), 0.0) << (s.server_time_ns - born) / 1000 << " us of silence";
    ++silent;
  }
  EXPECT_GT(silent, 0) << "no state of a silence longer than 200 ms was seen";
  EXPECT_TRUE(connection_->open(controller("the next one"))->connected());
}

INSTANTIATE_TEST_SUITE_P(By, LostClient, ::testing::Values(SIGKILL, SIGSTOP), [](const auto& by) {
  return std::string(by.param == SIGKILL ? "Sigkill" : "Sigstop");
});

TEST_F(Pressing, BriefPauseComesBackAsRamp) {
  wall_->signal(SIGSTOP);
  ASSERT_TRUE(eventually([](const client::DeviceState& s) {
    return s.state == client::Lifecycle::kArmed && s.tau_elastic.at(0) == 0.0 &&
           s.proxy_age > milliseconds(300);
  }));
  wall_->signal(SIGCONT);
  EXPECT_TRUE(engaged()) << "the wall asks for force again by itself (re_engage)";
  const auto seen = states();
  for (std::size_t i = 1; i < seen.size(); ++i) {
    const double dt =
        1e-9 * static_cast<double>(seen[i].server_time_ns - seen[i - 1].server_time_ns);
    ASSERT_LE(seen[i].gain - seen[i - 1].gain, dt / 0.2 + 1e-9) << "gain rose by a step";
  }
}

// The kernel goes by the smallest latency that any program asks for; it answers in us.
TEST_F(Served, IdleProcessorsStayAwake) {
  const auto session = connection_->open(controller("keeps them awake"));
  std::fstream latency("/dev/cpu_dma_latency", std::ios::in | std::ios::out | std::ios::binary);
  if (!latency) GTEST_SKIP() << "this host does not let its processors be kept awake";
  std::int32_t longest_us = -1;
  latency.read(reinterpret_cast<char*>(&longest_us), sizeof longest_us);
  EXPECT_EQ(longest_us, 0);
}

}  // namespace
}  // namespace haptic
