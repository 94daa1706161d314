#include "server/owner/telemetry/service_manager.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <cstdlib>
#include <vector>

#include "server/base/descriptor.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::server {
namespace {

using std::chrono::milliseconds;

struct Manager {
  explicit Manager(std::optional<core::Duration> watchdog)
      : service([this](const std::string& state) { heard.push_back(state); }, watchdog) {}
  std::vector<std::string> heard{};
  ServiceManager service;
};

TEST(ServiceManager, IsFedWhileTheLoopTicks) {
  Manager manager(milliseconds(2000));
  manager.service.pulse(1);
  manager.service.pulse(501);
  EXPECT_EQ(manager.heard, (std::vector<std::string>{"WATCHDOG=1", "WATCHDOG=1"}));
}

TEST(ServiceManager, StalledLoopDoesNotFeedIt) {
  Manager manager(milliseconds(2000));
  manager.service.pulse(0);  // before the first tick
  EXPECT_TRUE(manager.heard.empty());
  manager.service.pulse(7);
  manager.service.pulse(7);
  manager.service.pulse(7);
  EXPECT_EQ(manager.heard.size(), 1u);
}

TEST(ServiceManager, IsFedTwicePerWatchdogTime) {
  EXPECT_EQ(Manager(milliseconds(2000)).service.pulse_period(), milliseconds(500));
}

TEST(ServiceManager, FeedsNothingWithoutAWatchdog) {
  Manager manager(std::nullopt);
  EXPECT_FALSE(manager.service.pulse_period().has_value());
  manager.service.pulse(5);
  EXPECT_TRUE(manager.heard.empty());
}

TEST(ServiceManager, LearnsOfStartAndEnd) {
  Manager manager(std::nullopt);
  manager.service.ready("serving 'x'");
  manager.service.stopping();
  ASSERT_EQ(manager.heard.size(), 2u);
  EXPECT_EQ(manager.heard[0], "READY=1\nSTATUS=serving 'x'");
  EXPECT_EQ(manager.heard[1].rfind("STOPPING=1\n", 0), 0u);
}

TEST(ServiceManager, OneThatHangsHoldsNothingUp) {
  const test::ScratchFolder folder;
  const std::string place = folder.path() / "notify";
  const Descriptor manager(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  place.copy(name.sun_path, sizeof name.sun_path - 1);
  ASSERT_EQ(bind(manager.get(), reinterpret_cast<const sockaddr*>(&name), sizeof name), 0);
  setenv("NOTIFY_SOCKET", place.c_str(), 1);
  const ServiceManager service = ServiceManager::of_environment();
  service.stopping();
  std::array<char, 200> heard{};
  ASSERT_GT(recv(manager.get(), heard.data(), heard.size(), MSG_DONTWAIT), 0);
  EXPECT_EQ(std::string(heard.data()).rfind("STOPPING=1\n", 0), 0U);
  const Descriptor other(socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  ASSERT_EQ(connect(other.get(), reinterpret_cast<const sockaddr*>(&name), sizeof name), 0);
  while (send(other.get(), "x", 1, 0) > 0) continue;  // its queue is full
  service.stopping();                                 // returns
  unsetenv("NOTIFY_SOCKET");
}

}  // namespace
}  // namespace haptic::server
