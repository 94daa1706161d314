/// Asking for force, giving it up, losing it; losing the server. When the background asks, and when
/// another stream is opened, is tested in rules/.

#include <atomic>
#include <thread>

#include "tests/client/support/fake_server.hpp"

namespace haptic::test {
namespace {

using client::ClientError;
using client::Connection;
using client::ErrorReason;
using client::Lifecycle;
using std::chrono::milliseconds;

/// Longer than any of the client's retries: what did not happen by then does not happen.
constexpr milliseconds kLongEnough{600};

grpc::Status not_yet(const std::string& reason) {
  return refusal(grpc::StatusCode::FAILED_PRECONDITION, reason, "not good enough yet");
}
const grpc::Status kNoLease =
    refusal(grpc::StatusCode::PERMISSION_DENIED, "NOT_CONTROLLER", "the lease is over");

client::SessionOptions with(client::Reconnect reconnect, bool re_engage = false) {
  return {.reconnect = reconnect, .re_engage = re_engage};
}
constexpr auto kNever = client::Reconnect::kNever;
constexpr auto kWithBackoff = client::Reconnect::kWithBackoff;

/// A server and, once open() was called, a session with it.
class ClientForce : public WithServer {
 protected:
  void open(client::SessionOptions wanted) {
    wanted.on_event = [this](const client::Event&) { ++events; };
    session = WithServer::open(std::move(wanted));
  }
  void open_and_engage(client::SessionOptions wanted) {
    open(std::move(wanted));
    session->engage_when_ready();
    ASSERT_TRUE(asked(1));
    server.send_state(1, v1::DEVICE_STATE_NAME_ENGAGED);
    ASSERT_TRUE(server.until([&] { return session->state().state == Lifecycle::kEngaged; }));
  }
  [[nodiscard]] bool asked(std::size_t times, milliseconds patience = std::chrono::seconds(20)) {
    return server.until([&] { return server.heard().engages >= times; }, patience);
  }
  [[nodiscard]] bool opened_again() {
    return server.until([&] { return session->connected() && session->lease_epoch() == 2; });
  }

  std::atomic<int> events{0}, losses{0}, ends{0};  // outlive the session, whose callbacks count
  std::unique_ptr<client::Session> session;
};

TEST_F(ClientForce, EngageThrowsTheMissingCondition) {
  open({});
  server.answer_engage(not_yet("STREAM_TOO_YOUNG"));
  const ClientError error = error_of([&] { return session->engage(), 0; });
  EXPECT_EQ(error.reason(), ErrorReason::kNotReady);
  EXPECT_EQ(error.server_reason(), "STREAM_TOO_YOUNG");
  session->engage();  // the script is empty: agreed
  EXPECT_EQ(server.heard().engages, 2U);
}

TEST_F(ClientForce, IsAskedUntilTheServerAgrees) {
  for (const char* reason : {"NOT_ARMED", "STREAM_STALE"}) server.answer_engage(not_yet(reason));
  open({});
  session->engage_when_ready();
  ASSERT_TRUE(asked(3));
  EXPECT_FALSE(asked(4, kLongEnough)) << "asked again after the server had agreed";
}

TEST_F(ClientForce, ReleaseFollowsAnEngageUnderWay) {
  server.hold_engage(true);
  open({});
  session->engage_when_ready();
  ASSERT_TRUE(asked(1));
  std::thread releasing([&] { session->release(); });
  EXPECT_FALSE(server.until([&] { return server.heard().releases > 0; }, milliseconds(100)))
      << "the server could engage after it was told to release";
  server.hold_engage(false);
  releasing.join();
  EXPECT_EQ(server.heard().releases, 1U);
}

TEST_F(ClientForce, LossEndsTheAsking) {
  server.hold_engage(true);
  open({});
  session->engage_when_ready();
  ASSERT_TRUE(asked(1));
  server.send_event(v1::Event::KIND_LOST, "LOST");
  EXPECT_TRUE(server.until([&] { return session->engage_refusal().has_value(); }));
}

TEST_F(ClientForce, FaultEndsReEngage) {
  open_and_engage(with(kWithBackoff, true));
  // Somebody hits the emergency stop; later somebody else clears it.
  server.send_event(v1::Event::KIND_FAULT, "EMERGENCY_STOP");
  server.send_state(2, v1::DEVICE_STATE_NAME_FAULT);
  server.send_event(v1::Event::KIND_FAULT_CLEARED, "EMERGENCY_STOP");
  server.send_state(3, v1::DEVICE_STATE_NAME_ARMED);
  ASSERT_TRUE(server.until([&] { return session->state().seq == 3; }));
  EXPECT_FALSE(asked(2, kLongEnough)) << "clearing a fault must not bring force back";
  session->engage_when_ready();
  EXPECT_TRUE(asked(2));
}

TEST_F(ClientForce, EndIsFinalWithoutReconnect) {
  client::SessionOptions wanted;
  wanted.on_disconnect = [&](const ClientError&, bool retry) { retry ? ++losses : ++ends; };
  open(wanted);
  server.die();
  ASSERT_TRUE(server.until([&] { return ends == 1; }));
  EXPECT_EQ(losses, 0);
  EXPECT_FALSE(session->connected());
  session->publish(client::Proxy::free());  // goes nowhere
  EXPECT_EQ(error_of([&] { return session->wait_for_state(); }).reason(), ErrorReason::kClosed);
  EXPECT_EQ(error_of([&] { return session->engage(), 0; }).reason(), ErrorReason::kClosed);
}

TEST_F(ClientForce, ReopenedSessionCountsOn) {
  open(with(kWithBackoff));
  server.send_state(100);
  ASSERT_EQ(session->wait_for_state().seq, 100U);
  session->publish(client::Proxy::free());
  ASSERT_TRUE(streamed(1));
  v1::SessionResponse ack;
  ack.mutable_ack()->set_accepted(5);
  server.send(ack);
  ASSERT_TRUE(server.until([&] { return session->statistics().accepted == 5; }));
  server.die();
  ASSERT_TRUE(server.until([&] { return !session->connected(); }));
  server.listen();
  ASSERT_TRUE(opened_again());
  server.send_state(1);  // a new server counts its ticks from the beginning
  EXPECT_EQ(session->wait_for_state().seq, 1U);
  session->publish(client::Proxy::free());
  ASSERT_TRUE(streamed(2));
  const auto samples = server.heard().samples;
  EXPECT_GT(samples[1].seq(), samples[0].seq());
  EXPECT_EQ(samples[1].device_seq_used(), 1U);
  ack.mutable_ack()->set_accepted(2);  // the server counts per stream, the session all of them
  server.send(ack);
  EXPECT_TRUE(server.until([&] { return session->statistics().accepted == 7; }));
}

TEST_F(ClientForce, EarlierLeaseIsNotOnesOwn) {
  open(with(kWithBackoff));
  server.send_event(v1::Event::KIND_LEASE_EXPIRED, "LEASE_EXPIRED", 7);
  ASSERT_TRUE(server.until([&] { return events == 1; }));
  session->publish(client::Proxy::free());
  EXPECT_TRUE(server.until([&] { return !server.heard().samples.empty(); }));
  EXPECT_EQ(server.heard().openings.size(), 1U);
}

/// A client that was paused hears of the loss, asks for force at once, and is refused: its lease is
/// over, which it hears only then. The next sample takes the device up again, force included.
TEST_F(ClientForce, IsAskedUnderTheNextLease) {
  open_and_engage(with(kWithBackoff, true));
  server.answer_engage(kNoLease);
  server.send_state(2, v1::DEVICE_STATE_NAME_ARMED);
  ASSERT_TRUE(asked(2));
  server.send_event(v1::Event::KIND_LEASE_EXPIRED, "LEASE_EXPIRED");
  ASSERT_TRUE(server.until([&] { return events == 1; }));
  const std::size_t so_far = server.heard().engages + 1;  // one may be under way
  EXPECT_FALSE(asked(so_far + 1, kLongEnough)) << "asked for force without a lease";
  session->publish(client::Proxy::free());
  ASSERT_TRUE(opened_again());
  EXPECT_TRUE(asked(so_far + 1));
}

TEST_F(ClientForce, ReturnsAfterReconnectIfAsked) {
  for (const bool re_engage : {false, true}) {
    FakeServer other;
    const auto reopened = Connection(other.address()).open(with(kWithBackoff, re_engage));
    reopened->engage_when_ready();
    ASSERT_TRUE(other.until([&] { return other.heard().engages == 1; }));
    other.send_state(1, v1::DEVICE_STATE_NAME_ENGAGED);
    ASSERT_EQ(reopened->wait_for_state().seq, 1U);
    other.die();
    ASSERT_TRUE(other.until([&] { return !reopened->connected(); }));
    other.listen();
    ASSERT_TRUE(other.until([&] { return reopened->connected(); }));
    const auto again = [&] { return other.heard().engages > 1; };
    EXPECT_EQ(re_engage ? other.until(again) : other.until(again, kLongEnough), re_engage);
  }
}

}  // namespace
}  // namespace haptic::test
