/// Asking for force, giving it up, losing it; losing the server.

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "haptic/client/client.hpp"
#include "tests/client/support/fake_server.hpp"

namespace haptic::test {
namespace {

using client::ClientError;
using client::Connection;
using client::ErrorReason;
using std::chrono::milliseconds;

/// Longer than any of the client's retries: what did not happen by then does not happen.
constexpr milliseconds kLongEnough{600};

grpc::Status not_yet(const std::string& reason) {
  return refusal(grpc::StatusCode::FAILED_PRECONDITION, reason, "not good enough yet");
}

client::SessionOptions re_engaging(client::Reconnect reconnect) {
  client::SessionOptions options;
  options.reconnect = reconnect;
  options.re_engage = true;
  return options;
}

TEST(Engage, OnceThrowsWhatTheServerMisses) {
  FakeServer server;
  const auto session = Connection(server.address()).open({});
  server.answer_engage(not_yet("STREAM_TOO_YOUNG"));
  try {
    session->engage();
    FAIL() << "a refusal must throw";
  } catch (const ClientError& error) {
    EXPECT_EQ(error.reason(), ErrorReason::kNotReady);
    EXPECT_EQ(error.server_reason(), "STREAM_TOO_YOUNG");
  }
  session->engage();  // the script is empty: agreed
  EXPECT_EQ(server.engages(), 2U);
}

TEST(Engage, WhenReadyAsksUntilTheServerAgreesAndThenNoMore) {
  FakeServer server;
  const char* const curable[] = {"NOT_ARMED",    "STREAM_TOO_YOUNG", "TOO_FEW_SAMPLES",
                                 "STREAM_STALE", "DEVICE_STALE",     "OUTSIDE_WINDOW"};
  for (const char* reason : curable) server.answer_engage(not_yet(reason));
  const auto session = Connection(server.address()).open({});
  session->engage_when_ready();
  ASSERT_TRUE(server.until([&] { return server.engages() == std::size(curable) + 1; }));
  EXPECT_EQ(server.engage_answers_left(), 0U);
  EXPECT_FALSE(server.until([&] { return server.engages() > std::size(curable) + 1; }, kLongEnough))
      << "asked again after the server had agreed";
}

TEST(Engage, WhenReadyStopsAtARefusalThatTimeCannotCure) {
  FakeServer server;
  server.answer_engage(refusal(grpc::StatusCode::PERMISSION_DENIED, "NOT_CONTROLLER", "observer"));
  const auto session = Connection(server.address()).open({});
  session->engage_when_ready();
  ASSERT_TRUE(server.until([&] { return server.engages() == 1; }));
  EXPECT_FALSE(server.until([&] { return server.engages() > 1; }, kLongEnough));
}

TEST(Engage, ReleaseEndsTheAsking) {
  FakeServer server;
  for (int i = 0; i < 1000; ++i) server.answer_engage(not_yet("STREAM_TOO_YOUNG"));
  const auto session = Connection(server.address()).open({});
  session->engage_when_ready();
  ASSERT_TRUE(server.until([&] { return server.engages() >= 2; }));
  session->release();
  EXPECT_EQ(server.releases(), 1U);
  const std::size_t asked = server.engages();
  EXPECT_FALSE(server.until([&] { return server.engages() > asked; }, kLongEnough));
}

TEST(Engage, ReleaseIsSaidAfterTheAnswerToAnEngageUnderWay) {
  FakeServer server;
  server.hold_engage(true);
  const auto session = Connection(server.address()).open({});
  session->engage_when_ready();
  ASSERT_TRUE(server.until([&] { return server.engages() == 1; }));
  std::thread releasing([&] { session->release(); });
  EXPECT_FALSE(server.until([&] { return server.releases() > 0; }, milliseconds(100)))
      << "the server could engage after it was told to release";
  server.hold_engage(false);
  releasing.join();
  EXPECT_EQ(server.releases(), 1U);
}

TEST(ReEngage, AsksAgainAfterForceWasLost) {
  FakeServer server;
  const auto session = Connection(server.address()).open(re_engaging(client::Reconnect::kNever));
  session->engage_when_ready();
  ASSERT_TRUE(server.until([&] { return server.engages() == 1; }));
  server.send_state(1, v1::DEVICE_STATE_NAME_ENGAGED);
  ASSERT_TRUE(server.until([&] { return session->state().state == client::Lifecycle::kEngaged; }));
  server.send_event(v1::Event::KIND_LOST, "LOST");
  server.send_state(2, v1::DEVICE_STATE_NAME_ARMED);
  EXPECT_TRUE(server.until([&] { return server.engages() >= 2; }));
}

TEST(ReEngage, ForceStaysAwayAfterALossWhereNobodyAskedForIt) {
  FakeServer server;
  const auto session = Connection(server.address()).open({});
  session->engage_when_ready();
  ASSERT_TRUE(server.until([&] { return server.engages() == 1; }));
  server.send_state(1, v1::DEVICE_STATE_NAME_ENGAGED);
  server.send_event(v1::Event::KIND_LOST, "LOST");
  server.send_state(2, v1::DEVICE_STATE_NAME_ARMED);
  EXPECT_FALSE(server.until([&] { return server.engages() > 1; }, kLongEnough));
}

TEST(ReEngage, AFaultIsNoLossThatForceReturnsFromByItself) {
  FakeServer server;
  const auto session =
      Connection(server.address()).open(re_engaging(client::Reconnect::kWithBackoff));
  session->engage_when_ready();
  ASSERT_TRUE(server.until([&] { return server.engages() == 1; }));
  server.send_state(1, v1::DEVICE_STATE_NAME_ENGAGED);
  ASSERT_TRUE(server.until([&] { return session->state().state == client::Lifecycle::kEngaged; }));
  // Somebody hit the emergency stop; later somebody else clears it.
  server.send_event(v1::Event::KIND_FAULT, "EMERGENCY_STOP");
  server.send_state(2, v1::DEVICE_STATE_NAME_FAULT);
  server.send_event(v1::Event::KIND_FAULT_CLEARED, "EMERGENCY_STOP");
  server.send_state(3, v1::DEVICE_STATE_NAME_ARMED);
  ASSERT_TRUE(server.until([&] { return session->state().seq == 3; }));
  EXPECT_FALSE(server.until([&] { return server.engages() > 1; }, kLongEnough))
      << "clearing a fault must not bring force back";
  session->engage_when_ready();  // asked anew, by the user
  EXPECT_TRUE(server.until([&] { return server.engages() == 2; }));
}

TEST(ServerDies, WithoutReconnectTheSessionEndsAndSaysSo) {
  FakeServer server;
  std::atomic<int> ends{0};
  std::atomic<bool> retry{true};
  client::SessionOptions options;
  options.on_disconnect = [&](const ClientError&, bool will_retry) {
    retry = will_retry;
    ++ends;
  };
  const auto session = Connection(server.address()).open(options);
  server.die();
  ASSERT_TRUE(server.until([&] { return ends == 1; }));
  EXPECT_FALSE(retry);
  EXPECT_FALSE(session->connected());
  session->publish(client::Proxy::free());  // goes nowhere, harms nobody
  try {
    static_cast<void>(session->wait_for_state());
    FAIL() << "there is no state to come";
  } catch (const ClientError& error) {
    EXPECT_EQ(error.reason(), ErrorReason::kClosed);
  }
  try {
    session->engage();
    FAIL() << "there is nobody to ask";
  } catch (const ClientError& error) {
    EXPECT_EQ(error.reason(), ErrorReason::kClosed);
  }
}

TEST(ServerDies, WithBackoffTheSessionComesBackAndItsStatesBeginAnew) {
  FakeServer server;
  std::atomic<bool> retry{false};
  client::SessionOptions options;
  options.reconnect = client::Reconnect::kWithBackoff;
  options.on_disconnect = [&](const ClientError&, bool will_retry) { retry = will_retry; };
  const auto session = Connection(server.address()).open(options);
  server.send_state(100);
  ASSERT_EQ(session->wait_for_state().seq, 100U);
  session->publish(client::Proxy::free());
  ASSERT_TRUE(server.until([&] { return server.samples().size() == 1; }));
  v1::SessionResponse ack;
  ack.mutable_ack()->set_accepted(5);
  server.send(ack);
  ASSERT_TRUE(server.until([&] { return session->statistics().accepted == 5; }));
  server.die();
  ASSERT_TRUE(server.until([&] { return retry.load(); }));
  server.revive();
  ASSERT_TRUE(server.until([&] { return session->connected(); }));
  EXPECT_EQ(session->lease_epoch(), 2U);
  server.send_state(1);  // a new server counts its ticks from the beginning
  EXPECT_EQ(session->wait_for_state().seq, 1U);
  session->publish(client::Proxy::free());
  ASSERT_TRUE(server.until([&] { return server.samples().size() == 2; }));
  EXPECT_GT(server.samples()[1].seq(), server.samples()[0].seq());
  EXPECT_EQ(server.samples()[1].device_seq_used(), 1U);
  ack.mutable_ack()->set_accepted(2);  // the server counts per stream, the session all of them
  server.send(ack);
  EXPECT_TRUE(server.until([&] { return session->statistics().accepted == 7; }));
}

TEST(ServerDies, ARefusalThatNoWaitingCuresEndsTheTrying) {
  FakeServer server;
  std::atomic<int> losses{0}, ends{0};
  client::SessionOptions options;
  options.reconnect = client::Reconnect::kWithBackoff;
  options.on_disconnect = [&](const ClientError& error, bool will_retry) {
    will_retry ? ++losses : ++ends;
    if (!will_retry) {
      EXPECT_EQ(error.reason(), ErrorReason::kNoSuchDevice);
    }
  };
  const auto session = Connection(server.address()).open(options);
  server.refuse_opening(refusal(grpc::StatusCode::NOT_FOUND, "NO_SUCH_DEVICE", "another scene"));
  server.end_session({grpc::StatusCode::UNAVAILABLE, "restarts"});
  ASSERT_TRUE(server.until([&] { return ends == 1; }));
  EXPECT_EQ(losses, 1);
  EXPECT_FALSE(server.until([&] { return server.openings().size() > 2; }, kLongEnough));
  try {
    static_cast<void>(session->wait_for_state());
    FAIL() << "there is no state to come";
  } catch (const ClientError& error) {
    EXPECT_EQ(error.reason(), ErrorReason::kClosed);
  }
}

TEST(LeaseExpired, TheNextSampleOpensTheSessionAnewWhereItReconnects) {
  FakeServer server;
  client::SessionOptions options;
  options.reconnect = client::Reconnect::kWithBackoff;
  std::atomic<bool> told{false};
  options.on_event = [&](const client::Event&) { told = true; };
  const auto session = Connection(server.address()).open(options);
  server.send_event(v1::Event::KIND_LEASE_EXPIRED, "LEASE_EXPIRED");
  ASSERT_TRUE(server.until([&] { return told.load(); }));
  EXPECT_FALSE(server.until([&] { return server.openings().size() > 1; }, milliseconds(300)))
      << "a silent client took the device back";
  session->publish(client::Proxy::free());
  ASSERT_TRUE(server.until([&] { return session->connected() && session->lease_epoch() == 2; }));
  session->publish(client::Proxy::free());
  EXPECT_TRUE(server.until([&] { return !server.samples().empty(); }));
}

TEST(LeaseExpired, OfAPredecessorIsNotTakenForOnesOwn) {
  FakeServer server;
  client::SessionOptions options;
  options.reconnect = client::Reconnect::kWithBackoff;
  std::atomic<bool> told{false};
  options.on_event = [&](const client::Event&) { told = true; };
  const auto session = Connection(server.address()).open(options);
  server.send_event(v1::Event::KIND_LEASE_EXPIRED, "LEASE_EXPIRED", 7);
  ASSERT_TRUE(server.until([&] { return told.load(); }));
  session->publish(client::Proxy::free());
  EXPECT_TRUE(server.until([&] { return !server.samples().empty(); }));
  EXPECT_EQ(server.openings().size(), 1U);
}

/// A client that was paused hears of the loss, asks for force at once, and is refused: its lease is
/// over, which it hears only now. The next sample takes the device up again, force included.
TEST(LeaseExpired, ForceIsAskedForAgainUnderTheNextLeaseAlthoughTheOldSessionWasRefused) {
  FakeServer server;
  client::SessionOptions options = re_engaging(client::Reconnect::kWithBackoff);
  std::atomic<bool> told{false};
  options.on_event = [&](const client::Event&) { told = true; };
  const auto session = Connection(server.address()).open(options);
  session->engage_when_ready();
  ASSERT_TRUE(server.until([&] { return server.engages() == 1; }));
  server.send_state(1, v1::DEVICE_STATE_NAME_ENGAGED);
  ASSERT_TRUE(server.until([&] { return session->state().seq == 1; }));
  server.answer_engage(
      refusal(grpc::StatusCode::PERMISSION_DENIED, "NOT_CONTROLLER", "the lease is over"));
  server.send_state(2, v1::DEVICE_STATE_NAME_ARMED);
  ASSERT_TRUE(server.until([&] { return server.engages() >= 2; }));
  server.send_event(v1::Event::KIND_LEASE_EXPIRED, "LEASE_EXPIRED");
  ASSERT_TRUE(server.until([&] { return told.load(); }));
  const std::size_t asked = server.engages() + 1;  // one may be under way
  EXPECT_FALSE(server.until([&] { return server.engages() > asked; }, kLongEnough))
      << "asked for force without a lease";
  session->publish(client::Proxy::free());
  ASSERT_TRUE(server.until([&] { return session->connected() && session->lease_epoch() == 2; }));
  EXPECT_TRUE(server.until([&] { return server.engages() > asked; }));
}

TEST(LeaseExpired, WithoutReEngageARefusalForItEndsTheAsking) {
  FakeServer server;
  client::SessionOptions options;
  options.reconnect = client::Reconnect::kWithBackoff;
  const auto session = Connection(server.address()).open(options);
  server.answer_engage(
      refusal(grpc::StatusCode::PERMISSION_DENIED, "NOT_CONTROLLER", "the lease is over"));
  session->engage_when_ready();
  ASSERT_TRUE(server.until([&] { return server.engages() == 1; }));
  EXPECT_FALSE(server.until([&] { return server.engages() > 1; }, kLongEnough));
}

TEST(ServerDies, ForceReturnsAfterReconnectOnlyWhereAskedFor) {
  for (const bool wanted : {false, true}) {
    FakeServer server;
    client::SessionOptions options = re_engaging(client::Reconnect::kWithBackoff);
    options.re_engage = wanted;
    const auto session = Connection(server.address()).open(options);
    session->engage_when_ready();
    ASSERT_TRUE(server.until([&] { return server.engages() == 1; }));
    server.send_state(1, v1::DEVICE_STATE_NAME_ENGAGED);
    ASSERT_EQ(session->wait_for_state().seq, 1U);
    server.die();
    ASSERT_TRUE(server.until([&] { return !session->connected(); }));
    server.revive();
    ASSERT_TRUE(server.until([&] { return session->connected(); }));
    if (wanted) {
      EXPECT_TRUE(server.until([&] { return server.engages() == 2; }));
    } else {
      EXPECT_FALSE(server.until([&] { return server.engages() > 1; }, kLongEnough));
    }
  }
}

}  // namespace
}  // namespace haptic::test
