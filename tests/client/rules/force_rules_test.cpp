/// When force is asked for in the background, on virtual time.

#include "force.hpp"

#include <gtest/gtest.h>

namespace haptic::client {
namespace {

using namespace std::chrono_literals;
constexpr Force::TimePoint kNow = Force::TimePoint(1000s);

ClientError refused(const std::string& reason, ErrorReason kind = ErrorReason::kNotReady) {
  return {kind, "no", reason};
}

/// A wish for force whose Engage is under way.
Force asking(bool again = false, bool next_lease = false) {
  Force force(again, next_lease);
  force.want(kNow);
  force.asked();
  return force;
}

TEST(Force, IsAskedForAtOnce) {
  Force force(false, false);
  EXPECT_FALSE(force.due());
  force.want(kNow);
  EXPECT_EQ(force.due(), kNow);
  force.asked();
  EXPECT_FALSE(force.due()) << "an answer is awaited";
}

TEST(Force, CurableRefusalIsRetriedSoon) {
  for (const char* reason :
       {"NOT_ARMED", "STREAM_TOO_YOUNG", "TOO_FEW_SAMPLES", "STREAM_STALE", "DEVICE_STALE",
        "TRACKER_STALE", "NEVER_FREE", "OUTSIDE_WINDOW", "NO_ANSWER", "TOO_FAST"}) {
    Force force = asking();
    EXPECT_FALSE(force.answered(refused(reason), true, kNow));
    EXPECT_EQ(force.due(), kNow + 50ms) << reason;
    EXPECT_EQ(force.refusal()->server_reason(), reason);
  }
  for (const ErrorReason kind : {ErrorReason::kTimeout, ErrorReason::kUnreachable}) {
    Force force = asking();
    EXPECT_FALSE(force.answered(refused("", kind), true, kNow));
    EXPECT_TRUE(force.due());
  }
}

TEST(Force, AnyOtherRefusalEndsTheAsking) {
  for (const char* reason : {"NOT_CONTROLLER", "IN_FAULT", ""}) {
    Force force = asking(true);
    EXPECT_FALSE(force.answered(refused(reason), true, kNow));
    EXPECT_FALSE(force.due()) << reason;
    EXPECT_TRUE(force.refusal());
  }
}

TEST(Force, EarlierSessionsRefusalDoesNotCount) {
  Force force = asking();
  EXPECT_FALSE(force.answered(refused("NOT_CONTROLLER"), false, kNow));
  EXPECT_TRUE(force.due());
}

TEST(Force, TheNextLeaseIsAskedToo) {
  Force force = asking(true, true);
  EXPECT_FALSE(force.answered(refused("NOT_CONTROLLER"), true, kNow));
  EXPECT_TRUE(force.due());
  force.asked();
  EXPECT_FALSE(force.answered(refused("IN_FAULT"), true, kNow));
  EXPECT_FALSE(force.due());
}

TEST(Force, AgreementEndsTheAsking) {
  Force force = asking();
  EXPECT_FALSE(force.answered(std::nullopt, true, kNow));
  EXPECT_FALSE(force.due());
  EXPECT_FALSE(force.refusal());
}

TEST(Force, ReEngageKeepsTheWish) {
  Force force = asking(true);
  EXPECT_FALSE(force.answered(std::nullopt, true, kNow));
  EXPECT_EQ(force.due(), kNow + 200ms) << "states say ENGAGING by then";
}

TEST(Force, ReleaseEndsTheAsking) {
  Force force = asking(true);
  force.release(false);
  EXPECT_FALSE(force.answered(refused("STREAM_TOO_YOUNG"), true, kNow));
  EXPECT_FALSE(force.due());
  EXPECT_FALSE(force.refusal());
}

TEST(Force, AnEngageTakenBackIsReleased) {
  Force force = asking(true);
  force.release(true);
  EXPECT_EQ(force.engage(), Force::Engage::kTakenBack);
  EXPECT_TRUE(force.answered(std::nullopt, true, kNow));
  EXPECT_FALSE(force.due());
}

TEST(Force, WishAfterReleaseIsAskedAgain) {
  Force force = asking();
  force.release(true);
  force.want(kNow);
  EXPECT_FALSE(force.answered(std::nullopt, true, kNow)) << "the last word was: engage";
  EXPECT_EQ(force.due(), kNow + 50ms);
}

TEST(Force, AFaultEndsTheAsking) {
  Force force(true, true);
  force.want(kNow);
  force.fault_seen(kNow + 251ms);
  EXPECT_FALSE(force.due());
  EXPECT_EQ(force.refusal()->reason(), ErrorReason::kNotReady);
}

TEST(Force, FaultMayPrecedeTheWish) {
  Force force(false, false);
  force.want(kNow);
  force.fault_seen(kNow + 250ms);  // the ClearFault before the wish is still under way
  EXPECT_TRUE(force.due());
}

TEST(Force, OnlyAWishIsGivenUp) {
  Force force(false, false);
  force.give_up(refused("LEASE_PREEMPTED"));
  EXPECT_FALSE(force.refusal());
}

}  // namespace
}  // namespace haptic::client
