/// A session in the role tracker: what it opens with, what its poses carry.

#include "tests/client/support/fake_server.hpp"

namespace haptic::test {
namespace {

using Tracker = WithServer;
using client::Pose;

TEST_F(Tracker, OpensInItsRoleWithPoses) {
  const auto session = open({.tracker = true, .client_name = "camera", .nominal_rate_hz = 120});
  ASSERT_EQ(server.heard().openings.size(), 1U);
  const v1::OpenSession opening = server.heard().openings.front();
  EXPECT_EQ(opening.role(), v1::ROLE_TRACKER);
  EXPECT_EQ(opening.nominal_rate_hz(), 120.0);
  EXPECT_FALSE(opening.udp_wanted()) << "its samples go on the stream";
  EXPECT_FALSE(opening.resumable()) << "it holds no lease";
  Pose pose{.position = {0.1, -0.2, 0.3},
            .orientation = {0.0, 0.6, 0.0, 0.8},
            .valid_for = std::chrono::microseconds(4321)};
  for (std::size_t sent = 1; sent <= 2; ++sent) {  // one at a time, so that none is replaced
    session->publish_pose(pose);
    ASSERT_TRUE(server.until([&] { return server.heard().poses.size() == sent; }));
  }
  const auto poses = server.heard().poses;
  const std::vector<double> position(poses[0].position().begin(), poses[0].position().end());
  const std::vector<double> turn(poses[0].orientation().begin(), poses[0].orientation().end());
  EXPECT_EQ(position, (std::vector<double>{0.1, -0.2, 0.3}));
  EXPECT_EQ(turn, (std::vector<double>{0.0, 0.6, 0.0, 0.8}));
  EXPECT_EQ(poses[0].valid_for_us(), 4321U);
  EXPECT_GT(poses[1].seq(), poses[0].seq());
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
