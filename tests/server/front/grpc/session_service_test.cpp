// The session stream over real sockets.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/server/support/test_client.hpp"

namespace haptic::test {
namespace {

TEST(SessionService, StatesComeDownInOrder) {
  LiveServer server;
  OpenSession session(server.channel());
  EXPECT_EQ(session.opened().device(), "rig");
  EXPECT_EQ(session.opened().lease_epoch(), 1U);
  EXPECT_EQ(session.opened().lease_timeout().seconds(), 2);
  EXPECT_EQ(session.opened().transport(), v1::TRANSPORT_GRPC);
  EXPECT_EQ(session.opened().session_id().size(), 32U);
  ASSERT_TRUE(eventually([&] { return session.sequence().size() > 100; }));
  const auto sequence = session.sequence();
  EXPECT_TRUE(std::is_sorted(sequence.begin(), sequence.end()));
  EXPECT_EQ(std::adjacent_find(sequence.begin(), sequence.end()), sequence.end());
}

TEST(SessionService, TheFirstMessageMustOpen) {
  LiveServer server;
  v1::SessionRequest sample;
  sample.mutable_proxy()->set_seq(1);
  TestSession session(server.channel(), sample);
  EXPECT_EQ(refusal(session.status()), (Refusal{grpc::StatusCode::INVALID_ARGUMENT, "PROTOCOL"}));
}

TEST(SessionService, EndsAStreamWithoutASession) {
  LiveServer server({{"127.0.0.1:0"}}, patient_config(), {}, {.open_within = 300ms});
  OpenSession opens(server.channel(), v1::ROLE_OBSERVER, "alice");
  const auto begin = std::chrono::steady_clock::now();
  const auto stub = v1::HapticService::NewStub(server.channel());
  grpc::ClientContext context;
  const auto silent = stub->Session(&context);
  v1::SessionResponse none;
  EXPECT_FALSE(silent->Read(&none));
  const grpc::Status status = silent->Finish();
  EXPECT_GE(std::chrono::steady_clock::now() - begin, 300ms);
  EXPECT_EQ(refusal(status), (Refusal{grpc::StatusCode::INVALID_ARGUMENT, "PROTOCOL"}));
  EXPECT_NE(status.error_message().find("OpenSession did not come within 300 ms"),
            std::string::npos);
  EXPECT_FALSE(opens.ended());  // who opened stays
}

TEST(SessionService, OpeningTwiceEndsTheSession) {
  LiveServer server;
  OpenSession session(server.channel());
  session.send(open_message(v1::ROLE_CONTROLLER, "alice"));
  EXPECT_EQ(session.status().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_TRUE(eventually([&] { return server.rig.sessions->controller().empty(); }));
}

TEST(SessionService, NamesAWrongField) {
  LiveServer server;
  const auto refused_field = [&](const v1::SessionRequest& message) {
    TestSession session(server.channel(), message);
    EXPECT_EQ(session.status().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    return field_of(session.status());
  };
  const std::pair<const char*, void (*)(v1::OpenSession & open)> rows[] = {
      {"nominal_rate_hz", [](auto& open) { open.set_nominal_rate_hz(0); }},
      {"client_name", [](auto& open) { open.set_client_name(std::string(65, 'x')); }},
      {"role", [](auto& open) { open.set_role(v1::ROLE_UNSPECIFIED); }},
      {"state_rate_hz", [](auto& open) { open.set_state_rate_hz(5000); }},
      {"hold_end", [](auto& open) { open.mutable_hold_end()->set_seconds(-1); }},
      {"priority", [](auto& open) { open.set_priority(static_cast<v1::Priority>(9)); }}};
  for (const auto& [field, spoil] : rows) {
    auto message = open_message(v1::ROLE_CONTROLLER, "alice");
    spoil(*message.mutable_open());
    EXPECT_EQ(refused_field(message), field);
  }
  EXPECT_EQ(server.rig.sessions->controller(), "");
  EXPECT_EQ(server.rig.sessions->observers(), 0U);
}

TEST(SessionService, BadSamplesAreRejectedByName) {
  LiveServer server;
  OpenSession session(server.channel());
  ASSERT_TRUE(session.press());
  const double force = session.state().tau_a(0);
  session.publish({std::nan(""), 0.0});
  session.publish({1e9, 0.0});
  session.publish({0.0, 0.0, 0.0});
  session.publish({0.01, 0.0}, 1);  // a sequence that was
  EXPECT_TRUE(eventually(
      [&] { return session.ack().rejected_invalid() == 3 && session.ack().rejected_old() == 1; }));
  EXPECT_NE(session.ack().last_rejection().find("seq = 1"), std::string::npos);
  EXPECT_LE(std::abs(session.state().tau_a(0)), force + 1e-9);
  EXPECT_EQ(session.state().faults(), 0U);
}

TEST(SessionService, AnObserversSamplesAreNotUsed) {
  LiveServer server;
  OpenSession alice(server.channel());
  OpenSession bob(server.channel(), v1::ROLE_OBSERVER, "bob");
  bob.publish({0.4, 0.4});
  ASSERT_TRUE(eventually([&] { return bob.ack().rejected_old() == 1; }));
  EXPECT_EQ(bob.state().proxy_seq_used(), 0U);
  EXPECT_EQ(bob.engage().error_code(), grpc::StatusCode::PERMISSION_DENIED);
}

/// Force must be gone and the lease free without anybody's help, whichever way the client ends. How
/// soon: tests/relay (at every tick), LostClient (whole programs).
TEST(SessionService, EveryEndEndsForceAndLease) {
  const std::pair<const char*, void (TestSession::*)()> ends[] = {
      {"cancelled", &TestSession::cancel},
      {"half-closed", &TestSession::half_close},
      {"silent", &TestSession::stop_streaming}};
  for (const auto& [what, end] : ends) {
    SCOPED_TRACE(what);
    LiveServer server({{"127.0.0.1:0"}}, rig_config());
    TestSession observer(server.channel(), v1::ROLE_OBSERVER, "observer");
    OpenSession session(server.channel());
    ASSERT_TRUE(session.press());
    (session.*end)();
    EXPECT_TRUE(eventually([&] { return server.rig.sessions->controller().empty(); }));
    EXPECT_TRUE(eventually([&] { return server.rig.device->force == 0.0; }));
    EXPECT_TRUE(eventually([&] { return observer.state().state() == v1::DEVICE_STATE_NAME_IDLE; }));
    OpenSession next(server.channel(), v1::ROLE_CONTROLLER, "bob");
    EXPECT_EQ(next.opened().lease_epoch(), 2U);
  }
}

TEST(SessionService, TheStateRateIsHonoured) {
  LiveServer server;
  auto message = open_message(v1::ROLE_OBSERVER, "slow");
  message.mutable_open()->set_state_rate_hz(50);
  TestSession session(server.channel(), message);
  ASSERT_TRUE(eventually([&] { return session.sequence().size() > 20; }));
  const auto sequence = session.sequence();
  const auto ticks = sequence.back() - sequence.front();
  EXPECT_GE(ticks + 20, (sequence.size() - 1) * 20);  // never more often than every 20th tick
}

TEST(SessionService, OversizedMessageEndsOnlyItsSession) {
  LiveServer server;
  TestSession other(server.channel(), v1::ROLE_OBSERVER, "other");
  OpenSession session(server.channel());
  session.publish(std::vector<double>(20'000, 0.0));
  EXPECT_EQ(refusal(session.status()),
            (Refusal{grpc::StatusCode::RESOURCE_EXHAUSTED, "MESSAGE_TOO_LARGE"}));
  EXPECT_NE(session.status().error_message().find("at most 65536"), std::string::npos);
  EXPECT_EQ(detail_of(session.status(), "limit"), "65536");
  const std::size_t states = other.sequence().size();
  EXPECT_TRUE(eventually([&] { return other.sequence().size() > states + 20; }));
}

TEST(SessionService, GrpcRefusesFarBeyondTheLimit) {
  LiveServer server;
  OpenSession session(server.channel());
  session.publish(std::vector<double>(40'000, 0.0));
  EXPECT_EQ(refusal(session.status()), (Refusal{grpc::StatusCode::RESOURCE_EXHAUSTED, ""}));
}

}  // namespace
}  // namespace haptic::test
