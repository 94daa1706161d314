// The tracker's place and its door, on an injected clock.
#include "server/owner/rights/device_tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/support/allocation_guard.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;
using server::DeviceTracker;
using server::IngressVerdict;

core::PipelineConfig config() {
  core::PipelineConfig c{.tracker = core::TrackerSettings{1, {}}};
  c.device.q_lower = core::VecQ::Constant(7, -0.8);
  c.device.q_upper = core::VecQ::Constant(7, 0.8);
  return c;
}

server::LeaseRequest tracker_request(const std::string& id, double rate_hz = 100.0) {
  return {.session_id = id, .client_name = "client of " + id, .nominal_rate_hz = rate_hz};
}

struct Door {
  core::Mailbox<core::TrackerSnapshot> mailbox{};
  DeviceTracker tracker{mailbox, config(), std::nullopt, 2s};
  core::TimePoint now{1h};
  std::array<double, 3> position{0.1, -0.2, 0.3};
  std::array<double, 4> orientation{0.0, 0.0, 0.0, 1.0};
  std::uint64_t seq{0};
  std::string why{};

  IngressVerdict say(const std::string& id = "a") {
    ++seq;
    return again(id);
  }
  IngressVerdict again(const std::string& id = "a") { return say_pose(id, seq, 3, 4); }
  IngressVerdict say_pose(const std::string& id, std::uint64_t number, std::size_t positions,
                          std::size_t orientations) {
    server::PoseSample pose{.session_id = id,
                            .seq = number,
                            .arrival = now,
                            .position = {position.data(), positions},
                            .orientation = {orientation.data(), orientations}};
    const AllocationGuard guard;  // the loop's thread judges poses as well
    const server::Verdict verdict = tracker.accept(pose);
    EXPECT_EQ(guard.allocations(), 0U);
    why = verdict.why.str();
    return verdict.verdict;
  }
  std::string open_refusal(const std::string& id) {
    const auto answer = tracker.open(tracker_request(id), now);
    return answer ? "" : answer.refusal.reason.str();
  }
};

TEST(DeviceTracker, GoodPoseReachesTheLoop) {
  Door door;
  ASSERT_EQ(door.open_refusal("a"), "");
  EXPECT_EQ(door.tracker.client_name(), "client of a");
  // A turn of 1 rad about y, told with the other sign and rounded.
  door.orientation = {0.0, -1.004 * std::sin(0.5), 0.0, -1.004 * std::cos(0.5)};
  EXPECT_EQ(door.say(), IngressVerdict::kAccepted) << door.why;
  ASSERT_TRUE(door.mailbox.take());
  const core::TrackerSnapshot& pose = door.mailbox.value();
  EXPECT_EQ(pose.seq, 1u);
  EXPECT_EQ(pose.born, door.now);
  const double expected[] = {0.1, -0.2, 0.3, 0.0, 1.0, 0.0};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(pose.pose[i], expected[i], 1e-12) << i;
  // 2.5 periods of 100 Hz.
  EXPECT_EQ(pose.valid_for, 25ms);
}

TEST(DeviceTracker, SubnormalNumbersBecomeZero) {
  Door door;
  ASSERT_EQ(door.open_refusal("a"), "");
  door.position = {1e-310, -0.2, 5e-324};
  door.orientation = {1e-310, 0.0, 0.0, 1.0};
  ASSERT_EQ(door.say(), IngressVerdict::kAccepted) << door.why;
  ASSERT_TRUE(door.mailbox.take());
  const auto& pose = door.mailbox.value().pose;
  EXPECT_EQ(pose, (std::array<double, 6>{0.0, -0.2, 0.0, 0.0, 0.0, 0.0}));
}

TEST(DeviceTracker, RefusesAWrongPoseByName) {
  Door door;
  ASSERT_EQ(door.open_refusal("a"), "");
  ASSERT_EQ(door.say(), IngressVerdict::kAccepted);
  ASSERT_TRUE(door.mailbox.take());
  const auto refused = [&](IngressVerdict verdict, const std::string& sentence) {
    EXPECT_EQ(door.say(), verdict);
    EXPECT_EQ(door.why, sentence);
    door.position = {0.1, -0.2, 0.3};
    door.orientation = {0.0, 0.0, 0.0, 1.0};
  };
  door.position[1] = std::numeric_limits<double>::quiet_NaN();
  refused(IngressVerdict::kNotFinite, "position[1] = nan: must be finite");
  door.position[2] = 0.81;
  refused(IngressVerdict::kOutOfBounds, "position[2] = 0.81: must lie within -0.8 to 0.8 m");
  door.orientation[3] = std::numeric_limits<double>::infinity();
  refused(IngressVerdict::kNotFinite, "orientation[3] = inf: must be finite");
  door.orientation = {0.0, 0.0, 0.0, 0.0};
  refused(IngressVerdict::kOutOfBounds,
          "orientation has norm 0: must be a unit quaternion, within 0.01 of 1");
  door.orientation = {0.5, 0.5, 0.5, 0.6};
  refused(IngressVerdict::kOutOfBounds,
          "orientation has norm 1.05357: must be a unit quaternion, within 0.01 of 1");
  EXPECT_EQ(door.say_pose("a", 99, 2, 4), IngressVerdict::kWrongSize);
  EXPECT_EQ(door.why, "position has 2 values: must have 3, x, y, z in m");
  EXPECT_EQ(door.say_pose("a", 99, 3, 3), IngressVerdict::kWrongSize);
  EXPECT_EQ(door.why, "orientation has 3 values: must have 4, x, y, z, w");
  EXPECT_FALSE(door.mailbox.take()) << "nothing of it reached the loop";
}

TEST(DeviceTracker, AnOldSequenceIsRefused) {
  Door door;
  ASSERT_EQ(door.open_refusal("a"), "");
  door.seq = 6;
  EXPECT_EQ(door.say(), IngressVerdict::kAccepted);
  EXPECT_EQ(door.again(), IngressVerdict::kOldSequence);
  EXPECT_EQ(door.why, "seq = 7: must be above 7");
  door.seq = 2;
  EXPECT_EQ(door.say(), IngressVerdict::kOldSequence);
}

TEST(DeviceTracker, NextOneWaitsUntilPoseFaded) {
  Door door;
  ASSERT_EQ(door.open_refusal("a"), "");
  EXPECT_EQ(door.open_refusal("b"), "TRACKER_HELD");
  EXPECT_EQ(door.say(), IngressVerdict::kAccepted);
  EXPECT_EQ(door.say("b"), IngressVerdict::kOldEpoch);
  door.tracker.close("a");
  EXPECT_EQ(door.tracker.client_name(), "");
  EXPECT_EQ(door.say("a"), IngressVerdict::kOldEpoch);
  door.now += 179ms;
  EXPECT_EQ(door.open_refusal("b"), "TRACKER_HELD");
  door.now += 1ms;
  EXPECT_EQ(door.open_refusal("b"), "");
  door.seq = 0;  // numbers begin anew
  EXPECT_EQ(door.say("b"), IngressVerdict::kAccepted);
}

TEST(DeviceTracker, SilentTrackerLosesItsPlace) {
  Door door;
  ASSERT_EQ(door.open_refusal("a"), "");
  door.now += 1s;
  EXPECT_EQ(door.say(), IngressVerdict::kAccepted);
  door.now += 2s - 1ms;
  EXPECT_EQ(door.open_refusal("b"), "TRACKER_HELD");
  door.now += 1ms;
  EXPECT_EQ(door.open_refusal("b"), "");
  EXPECT_EQ(door.say("a"), IngressVerdict::kOldEpoch);
  door.tracker.close("a");  // its stream's end is no end of the other's
  EXPECT_EQ(door.tracker.client_name(), "client of b");
}

TEST(DeviceTracker, BurstAfterAStallIsOld) {
  Door door;
  ASSERT_EQ(door.open_refusal("a"), "");
  for (int i = 0; i < 20; ++i, door.now += 10ms) door.say();
  const core::TimePoint last_good = door.now - 10ms;
  door.now += 500ms;
  IngressVerdict verdict{};
  for (int i = 0; i < 20; ++i) verdict = door.say();  // all at once
  EXPECT_EQ(verdict, IngressVerdict::kBacklog);
  ASSERT_TRUE(door.mailbox.take());
  EXPECT_EQ(door.mailbox.value().seq, door.seq) << "the newest there is";
  EXPECT_EQ(door.mailbox.value().born, last_good);
}

}  // namespace
}  // namespace haptic::test
