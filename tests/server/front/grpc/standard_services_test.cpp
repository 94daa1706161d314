// When the standard health service says that hapticd is ill (what it says of a sound one, and
// reflection: interop.standard_services). Its stubs are not part of the distribution's headers, so
// its few bytes are written here by hand.
#include <gtest/gtest.h>

#include "tests/server/support/test_client.hpp"

namespace haptic::test {
namespace {

/// grpc.health.v1.Health/Check: request {1: service}, response {1: status}. 1 SERVING, 2
/// NOT_SERVING.
int health(const std::shared_ptr<grpc::Channel>& channel, const std::string& service) {
  const std::string request =
      service.empty() ? "" : std::string("\x0a") + static_cast<char>(service.size()) + service;
  const std::string answer = raw_call(channel, "/grpc.health.v1.Health/Check", request).second;
  return answer.size() == 2 && answer[0] == '\x08' ? answer[1] : 0;
}

TEST(Health, IsNotServingWithoutTheDevice) {
  LiveServer server;
  const auto channel = server.channel();
  server.rig.device->lost = true;
  EXPECT_TRUE(eventually([&] { return health(channel, "") == 2 && health(channel, "rig") == 2; }));
}

TEST(Health, IsNotServingWhileLoopHangs) {
  LiveServer server;
  const auto channel = server.channel();
  ASSERT_TRUE(eventually([&] { return health(channel, "rig") == 1; }));
  server.hung = true;
  EXPECT_TRUE(eventually([&] { return health(channel, "rig") == 2; }));
  server.hung = false;
  EXPECT_TRUE(eventually([&] { return health(channel, "rig") == 1; }));
}

TEST(Health, AnEmergencyStopIsNoIllness) {
  LiveServer server;
  const auto channel = server.channel();
  server.rig.sessions->emergency_stop("", [](const Outcome<Done>&) {});
  ASSERT_TRUE(eventually([&] { return server.rig.newest().faults().any(); }));
  EXPECT_TRUE(eventually([&] { return health(channel, "rig") == 1; }));
}

}  // namespace
}  // namespace haptic::test
