// Nobody reads hapticd's log: no path to zero force may wait for that.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>

#include <memory>
#include <thread>

#include "haptic/client/client.hpp"
#include "tests/support/temporary_file.hpp"
#include "tests/support/within.hpp"
#include "tests/system/process.hpp"

namespace haptic {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

/// Standard errors that a daemon may have, unread: a pipe as small as the kernel makes them, or a
/// terminal.
class Unread {
 public:
  explicit Unread(bool terminal) {
    if (terminal) {
      EXPECT_EQ(openpty(&ends_[0], &ends_[1], nullptr, nullptr, nullptr), 0);
    } else {
      EXPECT_EQ(pipe(ends_), 0);
      EXPECT_GT(fcntl(ends_[1], F_SETPIPE_SZ, 4096), 0);
    }
  }
  ~Unread() {
    close(ends_[0]);
    close(ends_[1]);
  }
  Unread(const Unread&) = delete;
  Unread& operator=(const Unread&) = delete;
  [[nodiscard]] int end() const { return ends_[1]; }
  void fill() const {
    // Through a description of our own: O_NONBLOCK on the shared one would be the daemon's too.
    const std::string same = "/proc/self/fd/" + std::to_string(ends_[1]);
    const int own = open(same.c_str(), O_WRONLY | O_NONBLOCK | O_NOCTTY);
    ASSERT_GE(own, 0);
    while (write(own, "x", 1) == 1) {
    }
    close(own);
  }

 private:
  int ends_[2]{-1, -1};
};

class UnreadLog : public testing::TestWithParam<bool> {};

TEST_P(UnreadLog, DelaysNoLeaseStopOrSigterm) {
  const Unread log(GetParam());
  const test::ScratchFolder folder;
  const std::string socket = folder.path() / "socket";
  test::Process daemon(
      std::string(HAPTIC_BINARY_DIR) + "/server/hapticd",
      {"--scene", std::string(HAPTIC_SOURCE_DIR) + "/server/scenes/finger_constant.textproto",
       "--listen", "unix:" + socket, "--set", "loop.late_bucket_full=1000000", "--set",
       "loop.loop_late_fault={seconds: 5}"},
      log.end());
  client::Connection connection("unix:" + socket);
  ASSERT_TRUE(test::eventually([&] {
    try {
      static_cast<void>(connection.server_info(milliseconds(500)));
      return true;
    } catch (const client::ClientError&) {
      return false;
    }
  }));
  const auto press = [&] {
    return std::make_unique<test::Process>(
        std::string(HAPTIC_BINARY_DIR) + "/client/haptic-example-virtual-wall",
        std::vector<std::string>{"--server", "unix:" + socket, "--stop", "0.3"});
  };
  auto wall = press();
  const auto device = [&] { return connection.devices().front(); };
  ASSERT_TRUE(test::eventually([&] { return device().state == client::Lifecycle::kEngaged; }));

  log.fill();
  // More lines than any buffer on the way holds.
  for (int i = 0; i < 100; ++i) {
    ASSERT_EQ(connection.emergency_stop({}, std::string(150, 'x')).size(), 1U);
    static_cast<void>(connection.clear_fault());
  }
  wall = press();
  ASSERT_TRUE(test::eventually([&] { return device().state == client::Lifecycle::kEngaged; }));
  wall->signal(SIGSTOP);
  EXPECT_TRUE(test::eventually([&] { return device().state == client::Lifecycle::kIdle; }))
      << "the lease of a silent controller ends";
  wall = press();
  ASSERT_TRUE(test::eventually([&] { return device().state == client::Lifecycle::kEngaged; }));
  EXPECT_EQ(connection.emergency_stop({}, "nobody reads this").size(), 1U);
  EXPECT_EQ(device().state, client::Lifecycle::kFault);
  static_cast<void>(connection.clear_fault());
  EXPECT_TRUE(test::eventually([&] { return device().state != client::Lifecycle::kFault; }));

  const auto asked = Clock::now();
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0);
  EXPECT_LT(Clock::now() - asked, std::chrono::seconds(5));
  std::filesystem::remove(socket);
}

INSTANTIATE_TEST_SUITE_P(Of, UnreadLog, testing::Values(false, true), [](const auto& of) {
  return of.param ? std::string("ATerminal") : std::string("APipe");
});

}  // namespace
}  // namespace haptic
