#include "server/owner/telemetry/service_manager.hpp"

#include <gtest/gtest.h>

#include <vector>

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

}  // namespace
}  // namespace haptic::server
