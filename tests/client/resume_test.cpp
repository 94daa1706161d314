/// A session that lost its stream takes it up again, and says so.

#include <atomic>
#include <mutex>

#include "tests/client/support/fake_server.hpp"

namespace haptic::test {
namespace {

class Resume : public WithServer {
 protected:
  /// Returns once the client has state 100.
  void tell_state(const client::Session& session, v1::DeviceStateName state) {
    server.send_state(100, state);
    ASSERT_TRUE(server.until([&] { return session.state().seq == 100; }));
  }
  /// Returns once the client has opened again.
  void lose_the_stream() {
    server.end_session({grpc::StatusCode::UNAVAILABLE, "the cable"});
    ASSERT_TRUE(server.until([&] { return server.heard().openings.size() == 2; }));
  }
};
using client::ClientError;
using client::Connection;
using client::ErrorReason;

client::SessionOptions reconnecting() {
  return {.client_name = "alice", .reconnect = client::Reconnect::kWithBackoff};
}

TEST_F(Resume, ALostStreamIsResumed) {
  server.resumes = true;
  std::mutex mutex;
  std::vector<std::string> heard;
  client::SessionOptions options = reconnecting();
  options.on_event = [&](const client::Event& event) {
    const std::lock_guard lock(mutex);
    heard.push_back(event.reason);
  };
  const auto session = open(options);
  EXPECT_TRUE(server.heard().openings.front().resumable());
  EXPECT_EQ(server.heard().openings.front().resume(), "");
  tell_state(*session, v1::DEVICE_STATE_NAME_ENGAGED);
  session->publish(client::Proxy::held({0.1, 0.2}));
  ASSERT_TRUE(streamed(1));

  lose_the_stream();
  EXPECT_EQ(server.heard().openings.back().resume(), "session-1");
  ASSERT_TRUE(server.until([&] { return session->connected(); }));
  EXPECT_EQ(session->state().seq, 100U) << "the device's ticks go on";
  EXPECT_EQ(session->lease_epoch(), 2U);
  server.send_event(v1::Event::KIND_LEASE, "LEASE_RESUMED", 2);
  ASSERT_TRUE(server.until([&] {
    const std::lock_guard lock(mutex);
    return heard == std::vector<std::string>{"LEASE_RESUMED"};
  }));
  session->publish(client::Proxy::held({0.1, 0.2}));
  ASSERT_TRUE(streamed(2));
  EXPECT_GT(server.heard().samples.back().seq(), server.heard().samples.front().seq());
}

TEST_F(Resume, AsksForTheEventsItMissed) {
  const auto session = open(reconnecting());
  server.send_event(v1::Event::KIND_STATE, "INIT -> IDLE", 1, 700);
  server.send_event(v1::Event::KIND_TRANSPORT, "SAMPLES GRPC -> UDP", 1, 900);
  tell_state(*session, v1::DEVICE_STATE_NAME_ARMED);
  lose_the_stream();
  EXPECT_EQ(server.heard().openings.front().events_after_ns(), 0);
  EXPECT_EQ(server.heard().openings.back().events_after_ns(), 700);
}

/// Resuming would carry on the force that was just given back.
TEST_F(Resume, ReleasedForceIsNotResumed) {
  server.resumes = true;
  std::atomic<client::Session*> held{nullptr};
  client::SessionOptions options = reconnecting();
  options.on_disconnect = [&](const ClientError&, bool) { held.load()->release(); };
  const auto session = open(options);
  held = session.get();
  tell_state(*session, v1::DEVICE_STATE_NAME_ENGAGED);
  lose_the_stream();
  EXPECT_EQ(server.heard().openings.back().resume(), "");
  ASSERT_TRUE(server.until([&] { return session->connected(); }));
}

TEST_F(Resume, AsksForNoneWithoutReconnect) {
  auto session = open();
  EXPECT_FALSE(server.heard().openings.front().resumable());
  session.reset();
  EXPECT_EQ(server.heard().farewells, 0U);
}

TEST_F(Resume, ClosingSaysFarewell) {
  auto session = open(reconnecting());
  session.reset();
  EXPECT_TRUE(server.until([&] { return server.heard().farewells == 1; }));
}

TEST_F(Resume, PreemptedSessionComesBackWithSample) {
  client::SessionOptions options = reconnecting();
  options.priority = client::Priority::kTest;
  const auto session = open(options);
  EXPECT_EQ(server.heard().openings.front().priority(), v1::PRIORITY_TEST);
  server.hold_engage(true);
  session->engage_when_ready();
  ASSERT_TRUE(server.until([&] { return server.heard().engages == 1; }));
  server.send_event(v1::Event::KIND_LEASE, "LEASE_PREEMPTED", 1);
  ASSERT_TRUE(server.until([&] {
    const auto refusal = session->engage_refusal();
    return refusal && refusal->reason() == ErrorReason::kLeaseHeld;
  }));
  server.hold_engage(false);
  EXPECT_EQ(server.heard().openings.size(), 1U);
  session->publish(client::Proxy::free());
  EXPECT_TRUE(server.until([&] { return server.heard().openings.size() == 2; }));
}

TEST(Tls, AnUnreadableFileIsNamed) {
  const auto refusal = [](const client::TlsOptions& tls) {
    const ClientError error =
        error_of([&] { return std::make_unique<Connection>("127.0.0.1:1", tls); });
    EXPECT_EQ(error.reason(), ErrorReason::kInvalidArgument);
    return std::string(error.what());
  };
  client::TlsOptions tls;
  const Connection without_files("127.0.0.1:1", tls);
  tls.ca_file = "nowhere/ca.pem";
  EXPECT_NE(refusal(tls).find("ca_file = 'nowhere/ca.pem'"), std::string::npos);
  tls.ca_file.clear();
  tls.key_file = "me.key";
  EXPECT_NE(refusal(tls).find("together"), std::string::npos);
}

}  // namespace
}  // namespace haptic::test
