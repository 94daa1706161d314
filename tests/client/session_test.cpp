/// A session from opening to its end: errors by reason, states, ends that never hang.

#include <atomic>
#include <stdexcept>

#include "tests/client/support/fake_server.hpp"
#include "tests/support/message_text.hpp"

namespace haptic::test {
namespace {

using ClientSession = WithServer;
using client::ClientError;
using client::ErrorReason;
using std::chrono::milliseconds;

TEST_F(ClientSession, ARefusedOpeningSaysWhy) {
  server.refuse_opening(
      refusal(grpc::StatusCode::ALREADY_EXISTS, "LEASE_HELD", "held by \"other\""));
  const ClientError error = error_of([&] { return open(); });
  EXPECT_EQ(error.reason(), ErrorReason::kLeaseHeld);
  EXPECT_EQ(error.server_reason(), "LEASE_HELD");
  EXPECT_STREQ(error.what(), "held by \"other\"");
}

TEST_F(ClientSession, OpensWithTheGivenOptions) {
  client::SessionOptions options{.device = "finger",
                                 .client_name = "a test",
                                 .nominal_rate_hz = 90.0,
                                 .state_rate_hz = 30.0,
                                 .hold_end = milliseconds(1050)};
  const auto session = open(options);
  ASSERT_EQ(server.heard().openings.size(), 1U);
  expect_text(server.heard().openings.front(), R"(
    device: "finger" role: ROLE_CONTROLLER client_name: "a test" nominal_rate_hz: 90
    state_rate_hz: 30 hold_end { seconds: 1 nanos: 50000000 } udp_wanted: true
    priority: PRIORITY_PRIMARY)");
  EXPECT_TRUE(session->connected());
  EXPECT_EQ(session->lease_epoch(), 1U);
  EXPECT_EQ(session->device().name, "finger");
  EXPECT_EQ(session->device().dofs.at(0).unit, "m");
}

TEST_F(ClientSession, NoServerIsUnreachable) {
  server.die();
  EXPECT_EQ(error_of([&] { return open(); }).reason(), ErrorReason::kUnreachable);
  EXPECT_EQ(error_of([&] { return connection.devices(); }).reason(), ErrorReason::kUnreachable);
}

TEST_F(ClientSession, ASilentServerIsATimeout) {
  server.answers_opening = false;
  client::SessionOptions options{.timeout = milliseconds(50)};
  EXPECT_EQ(error_of([&] { return open(options); }).reason(), ErrorReason::kTimeout);
}

TEST_F(ClientSession, WaitWithoutAStateTimesOut) {
  client::SessionOptions options;
  options.timeout = milliseconds(1000);  // also of the opening, on a slow machine
  const auto session = open(options);
  EXPECT_EQ(session->state().seq, 0U);
  server.send_state(7);
  EXPECT_EQ(session->wait_for_state().seq, 7U);
  EXPECT_EQ(session->state().seq, 7U);
  EXPECT_EQ(error_of([&] { return session->wait_for_state(); }).reason(), ErrorReason::kTimeout);
  EXPECT_STREQ(error_of([&] { return session->wait_for_state(milliseconds(3)); }).what(),
               "no state in 3 ms");
}

TEST_F(ClientSession, EndsWhileTheServerHangs) {
  server.read_samples(false);
  auto session = open();
  for (int i = 0; i < 1000; ++i) session->publish(client::Proxy::held(std::vector(2048, 1.0)));
  session.reset();  // a hang is ended by the test's own time limit
}

TEST_F(ClientSession, EndsWhileReopeningASilentServer) {
  client::SessionOptions options{.reconnect = client::Reconnect::kWithBackoff};
  options.timeout = std::chrono::hours(1);  // whatever waits for an answer waits for ever
  auto session = open(options);
  server.answers_opening = false;
  server.end_session({grpc::StatusCode::UNAVAILABLE, "gone"});
  ASSERT_TRUE(server.until([&] { return server.heard().openings.size() == 2; }));
  session.reset();
}

TEST_F(ClientSession, ThrowingCallbackDoesNotEndIt) {
  std::atomic<int> states{0}, events{0};
  client::SessionOptions options;
  options.on_state = [&](const client::DeviceState&) {
    ++states;
    throw std::runtime_error("the user's");
  };
  options.on_event = [&](const client::Event&) {
    ++events;
    throw 5;
  };
  const auto session = open(options);
  for (int i = 1; i <= 3; ++i) {
    server.send_state(static_cast<std::uint64_t>(i));
    server.send_event(v1::Event::KIND_STATE, "IDLE -> ARMED");
    ASSERT_TRUE(server.until([&] { return states == i && events == i; }));
  }
  EXPECT_TRUE(session->connected());
}

TEST_F(ClientSession, SlowCallbackSeesTheNewestState) {
  std::atomic<std::uint64_t> newest{0};
  std::atomic<int> calls{0}, inside{0}, overlaps{0};
  std::atomic<bool> blocked{true};
  client::SessionOptions options;
  options.on_state = [&](const client::DeviceState& state) {
    if (++inside > 1) ++overlaps;
    ++calls;
    static_cast<void>(server.until([&] { return !blocked; }));
    newest = state.seq;
    --inside;
  };
  const auto session = open(options);
  server.send_state(1);
  ASSERT_TRUE(server.until([&] { return calls == 1; }));
  for (std::uint64_t seq = 2; seq <= 50; ++seq) server.send_state(seq);
  // The transport is not held up by the callback: the poll sees all of them.
  ASSERT_TRUE(server.until([&] { return session->state().seq == 50; }));
  blocked = false;
  ASSERT_TRUE(server.until([&] { return newest == 50; }));
  EXPECT_EQ(calls, 2) << "what came meanwhile is conflated to the newest";
  EXPECT_EQ(overlaps, 0);
}

TEST_F(ClientSession, CallbackThatTurnsSlowDoesToo) {
  std::atomic<std::uint64_t> newest{0};
  std::atomic<bool> blocks{false}, blocked{false};
  client::SessionOptions options;
  options.on_state = [&](const client::DeviceState& state) {
    if (blocks.exchange(false)) {
      blocked = true;
      static_cast<void>(server.until([&] { return !blocked; }));
    }
    newest = state.seq;
  };
  const auto session = open(options);
  std::uint64_t seq = 0;
  while (seq < 300) {
    server.send_state(++seq);
    ASSERT_TRUE(server.until([&] { return newest == seq; }));
  }
  blocks = true;
  for (int i = 0; i < 50; ++i) server.send_state(++seq);
  ASSERT_TRUE(server.until([&] { return blocked.load(); }));
  session->publish(client::Proxy::free());
  EXPECT_TRUE(streamed(1)) << "held up by it";
  blocked = false;
  EXPECT_TRUE(server.until([&] { return newest == seq; }));
}

TEST_F(ClientSession, SettingsTravelAndClampsComeBack) {
  const auto session = open();
  client::Settings settings;
  settings.stiffness = {900.0};
  const client::AppliedSettings answer = session->update(settings);
  expect_text(server.heard().update, R"(session_id: "session-1" stiffness: 900)");
  ASSERT_EQ(answer.clamped.size(), 1U);
  EXPECT_EQ(answer.clamped[0].field, "stiffness[0]");
  EXPECT_EQ(answer.clamped[0].applied, 400.0);
  EXPECT_EQ(answer.renderer, client::Renderer::kSubspaceLinear);
}

TEST_F(ClientSession, APersistentFaultIsNotCleared) {
  const ClientError error = error_of([&] { return connection.clear_fault(); });
  EXPECT_EQ(error.reason(), ErrorReason::kNotReady);
  EXPECT_EQ(error.server_reason(), "FAULT_PERSISTS");
}

}  // namespace
}  // namespace haptic::test
