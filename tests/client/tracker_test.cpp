/// A session in the role tracker: what it opens with, what its poses carry.

#include "tests/client/support/fake_server.hpp"
#include "tests/support/message_text.hpp"

namespace haptic::test {
namespace {

using Tracker = WithServer;
using client::Pose;

TEST_F(Tracker, OpensInItsRoleWithPoses) {
  const auto session = open({.tracker = true, .client_name = "camera", .nominal_rate_hz = 120});
  ASSERT_EQ(server.heard().openings.size(), 1U);
  // No udp_wanted: its samples go on the stream. Not resumable: it holds no lease.
  expect_text(server.heard().openings.front(), R"(
    role: ROLE_TRACKER client_name: "camera" nominal_rate_hz: 120 priority: PRIORITY_PRIMARY)");
  Pose pose{.position = {0.1, -0.2, 0.3},
            .orientation = {0.0, 0.6, 0.0, 0.8},
            .valid_for = std::chrono::microseconds(4321)};
  for (std::size_t sent = 1; sent <= 2; ++sent) {  // one at a time, so that none is replaced
    session->publish_pose(pose);
    ASSERT_TRUE(server.until([&] { return server.heard().poses.size() == sent; }));
  }
  const auto poses = server.heard().poses;
  for (std::size_t i = 0; i < 2; ++i) {
    expect_text(poses[i],
                "valid_for_us: 4321 position: [0.1, -0.2, 0.3] "
                "orientation: [0, 0.6, 0, 0.8] seq: " +
                    std::to_string(i + 1));
  }
  EXPECT_TRUE(server.heard().samples.empty());
  EXPECT_EQ(session->statistics().published, 2U);
}

TEST_F(Tracker, IsNotAnObserverToo) {
  const auto error = error_of([&] { return open({.observer = true, .tracker = true}); });
  EXPECT_EQ(error.reason(), client::ErrorReason::kInvalidArgument);
  EXPECT_TRUE(server.heard().openings.empty());
}

}  // namespace
}  // namespace haptic::test
