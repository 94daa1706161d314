/// When a session opens another stream, on virtual time.

#include "reconnection.hpp"

#include <gtest/gtest.h>

namespace haptic::client {
namespace {

using namespace std::chrono_literals;
using State = Reconnection::State;
constexpr Reconnection::TimePoint kEndedAt = Reconnection::TimePoint(1000s);
const ClientError kGone(ErrorReason::kUnreachable, "gone");

Reconnection open_session(bool wanted = true) {
  Reconnection reconnection(wanted);
  EXPECT_TRUE(reconnection.begin());
  reconnection.opened();
  EXPECT_TRUE(reconnection.open());
  return reconnection;
}

/// Delay of the attempt that follows an end at kEndedAt.
Reconnection::TimePoint::duration next_delay(Reconnection& reconnection) {
  reconnection.ended(kGone);
  EXPECT_TRUE(reconnection.retry(kEndedAt));
  const auto due = reconnection.due();
  EXPECT_TRUE(reconnection.begin());
  return due - kEndedAt;
}

TEST(Reconnection, DelaysDoubleUpToHalfSecond) {
  Reconnection reconnection = open_session();
  for (const auto delay : {0ms, 100ms, 200ms, 400ms, 500ms, 500ms}) {
    EXPECT_EQ(next_delay(reconnection), delay);
  }
  reconnection.opened();
  EXPECT_EQ(next_delay(reconnection), 0ms) << "an opening begins the row anew";
}

TEST(Reconnection, EndIsFinalIfDisabled) {
  Reconnection reconnection = open_session(false);
  reconnection.ended(kGone);
  EXPECT_FALSE(reconnection.over()) << "the user has not heard of it yet";
  EXPECT_FALSE(reconnection.retry(kEndedAt));
  EXPECT_TRUE(reconnection.over());
  EXPECT_EQ(reconnection.due(), Reconnection::TimePoint::max());
}

TEST(Reconnection, OnlyLastingRefusalsEndTheTrying) {
  const std::pair<ErrorReason, bool> table[] = {
      {ErrorReason::kNoSuchDevice, true},     {ErrorReason::kInvalidArgument, true},
      {ErrorReason::kPermissionDenied, true}, {ErrorReason::kProtocol, true},
      {ErrorReason::kUnreachable, false},     {ErrorReason::kTimeout, false},
      {ErrorReason::kLeaseHeld, false},       {ErrorReason::kNotReady, false},
      {ErrorReason::kClosed, false}};
  for (const auto& [reason, lasting] : table) {
    SCOPED_TRACE(static_cast<int>(reason));
    Reconnection reconnection = open_session();
    static_cast<void>(next_delay(reconnection));
    reconnection.ended({reason, "no"});
    EXPECT_EQ(reconnection.retry(kEndedAt), !lasting);
    EXPECT_EQ(reconnection.over(), lasting);
    EXPECT_EQ(reconnection.why().reason(), reason);
  }
}

TEST(Reconnection, OnlyAnOpeningCanBeAnswered) {
  Reconnection reconnection = open_session();
  reconnection.ended(kGone);
  reconnection.opened();  // after the attempt was given up
  EXPECT_EQ(reconnection.state(), State::kEnded);
}

TEST(Reconnection, AnEndCountsOnce) {
  Reconnection reconnection = open_session();
  reconnection.ended(kGone);
  EXPECT_TRUE(reconnection.retry(kEndedAt));
  reconnection.ended({ErrorReason::kProtocol, "the same stream again"});
  EXPECT_EQ(reconnection.state(), State::kWaiting);
  EXPECT_EQ(reconnection.why().reason(), ErrorReason::kUnreachable);
}

TEST(Reconnection, LostLeaseLeavesTheStreamOpen) {
  Reconnection reconnection = open_session();
  reconnection.lease_lost();
  EXPECT_TRUE(reconnection.open());
  EXPECT_EQ(reconnection.state(), State::kLeaseLost);
  EXPECT_EQ(next_delay(reconnection), 0ms);
}

TEST(Reconnection, ClosedIsForGood) {
  Reconnection reconnection = open_session();
  reconnection.close();
  EXPECT_FALSE(reconnection.open());
  EXPECT_TRUE(reconnection.over());
  reconnection.ended(kGone);
  EXPECT_FALSE(reconnection.retry(kEndedAt));
  EXPECT_FALSE(reconnection.begin());
  EXPECT_TRUE(reconnection.closed());
}

}  // namespace
}  // namespace haptic::client
