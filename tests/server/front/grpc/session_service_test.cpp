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

TEST(SessionService, PressesOverAUnixSocketToo) {
  const std::string path = "/tmp/haptic_rpc_test_" + std::to_string(::getpid()) + ".sock";
  LiveServer server({{"unix:" + path}});
  OpenSession session(server.channel());
  ASSERT_TRUE(session.press());
  EXPECT_NEAR(session.state().tau_a(0), 1.0, 1e-9);  // 0.01 m at 100 N/m
  EXPECT_EQ(session.state().transport(), v1::TRANSPORT_GRPC);
}

TEST(SessionService, PlanesHoldTheProxy) {
  core::PipelineConfig config = patient_config();
  config.passivity.tank.enabled = true;
  config.passivity.tank.initial = 0.002;
  LiveServer server({{"127.0.0.1:0"}}, config);
  OpenSession session(server.channel());
  v1::SessionRequest message;
  v1::ProxySample& sample = *message.mutable_proxy();
  sample.set_seq(1);
  sample.set_mode(v1::PROXY_MODE_PLANES);
  sample.add_position(0.0);
  sample.add_position(0.0);
  v1::Plane& far = *sample.add_planes();
  far.add_normal(0.0);
  far.add_normal(1.0);
  far.set_offset(5.0);
  v1::Plane& near = *sample.add_planes();
  near.add_normal(2.0);
  near.add_normal(0.0);
  near.set_offset(-0.02);  // a <= -0.01, the probe is at 0
  ASSERT_TRUE(session.send(message));
  ASSERT_TRUE(eventually([&] { return session.state().active_planes() == 2U; }));
  const v1::DeviceState state = session.state();
  EXPECT_EQ(state.mode(), v1::PROXY_MODE_PLANES);
  EXPECT_NEAR(state.x(0), -0.01, 1e-12);
  EXPECT_EQ(state.x(1), state.x_probe(1));
  ASSERT_TRUE(state.has_passivity());
  EXPECT_EQ(state.passivity().tank(), 0.002);

  sample.set_seq(2);
  sample.mutable_planes(1)->mutable_normal()->RemoveLast();
  ASSERT_TRUE(session.send(message));
  ASSERT_TRUE(eventually([&] { return session.ack().rejected_invalid() == 1; }));
  EXPECT_NE(session.ack().last_rejection().find("planes[1].normal"), std::string::npos);
}

TEST(SessionService, SecondControllerLearnsTheHoldersName) {
  LiveServer server;
  OpenSession alice(server.channel());
  TestSession bob(server.channel(), v1::ROLE_CONTROLLER, "bob");
  EXPECT_EQ(refusal(bob.status()), (Refusal{grpc::StatusCode::ALREADY_EXISTS, "LEASE_HELD"}));
  EXPECT_NE(bob.status().error_message().find("'alice'"), std::string::npos);
  OpenSession carol(server.channel(), v1::ROLE_OBSERVER, "carol");
}

TEST(SessionService, TheFirstMessageMustOpen) {
  LiveServer server;
  v1::SessionRequest sample;
  sample.mutable_proxy()->set_seq(1);
  TestSession session(server.channel(), sample);
  EXPECT_EQ(refusal(session.status()), (Refusal{grpc::StatusCode::INVALID_ARGUMENT, "PROTOCOL"}));
}

/// A stream on which the client says nothing.
struct SilentStream {
  explicit SilentStream(const std::shared_ptr<grpc::Channel>& channel)
      : stub(v1::HapticService::NewStub(channel)), stream(stub->Session(&context)) {}
  ~SilentStream() { context.TryCancel(); }
  [[nodiscard]] grpc::Status status() {
    v1::SessionResponse none;
    EXPECT_FALSE(stream->Read(&none));
    return stream->Finish();
  }
  grpc::ClientContext context;
  std::unique_ptr<v1::HapticService::Stub> stub;
  std::unique_ptr<grpc::ClientReaderWriter<v1::SessionRequest, v1::SessionResponse>> stream;
};

TEST(SessionService, EndsAStreamWithoutASession) {
  LiveServer server({{"127.0.0.1:0"}}, patient_config(), {}, {.open_within = 300ms});
  OpenSession opens(server.channel(), v1::ROLE_OBSERVER, "alice");
  const auto begin = std::chrono::steady_clock::now();
  SilentStream silent(server.channel());
  const grpc::Status status = silent.status();
  EXPECT_GE(std::chrono::steady_clock::now() - begin, 300ms);
  EXPECT_EQ(refusal(status), (Refusal{grpc::StatusCode::INVALID_ARGUMENT, "PROTOCOL"}));
  EXPECT_NE(status.error_message().find("OpenSession did not come within 300 ms"),
            std::string::npos);
  EXPECT_FALSE(opens.ended());  // who opened stays
}

TEST(SessionService, IdleStreamsLeaveRoomForOthers) {
  // And 66 streams without a session.
  LiveServer server({.listen = {"127.0.0.1:0"}, .max_sessions = 1}, patient_config(), {},
                    {.open_within = 60s});
  std::vector<std::unique_ptr<SilentStream>> silent;
  for (int i = 0; i < 67; ++i) {
    grpc::ChannelArguments own;  // a connection of its own each, so that no limit of one helps
    own.SetInt("hapticd.test.connection", i);
    silent.push_back(std::make_unique<SilentStream>(
        grpc::CreateCustomChannel(server.address(), grpc::InsecureChannelCredentials(), own)));
  }
  // One too many: whoever waited longest has to go.
  std::atomic<int> ended{0};
  std::vector<std::thread> readers;
  for (const auto& stream : silent) {
    readers.emplace_back([&] {
      const grpc::Status status = stream->status();
      if (reason_of(status) != "TOO_MANY_SESSIONS") return;
      EXPECT_EQ(detail_of(status, "limit"), "66");
      ++ended;
    });
  }
  ASSERT_TRUE(eventually([&] {
    TestSession session(server.channel());
    return session.wait_opened();
  }));
  EXPECT_TRUE(eventually([&] { return ended >= 1; }));
  for (const auto& stream : silent) stream->context.TryCancel();
  for (std::thread& reader : readers) reader.join();
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
  auto message = open_message(v1::ROLE_CONTROLLER, "alice");
  message.mutable_open()->set_nominal_rate_hz(0);
  EXPECT_EQ(refused_field(message), "nominal_rate_hz");
  message = open_message(v1::ROLE_CONTROLLER, std::string(65, 'x'));
  EXPECT_EQ(refused_field(message), "client_name");
  message = open_message(v1::ROLE_UNSPECIFIED, "alice");
  EXPECT_EQ(refused_field(message), "role");
  message = open_message(v1::ROLE_OBSERVER, "alice");
  message.mutable_open()->set_state_rate_hz(5000);
  EXPECT_EQ(refused_field(message), "state_rate_hz");
  message = open_message(v1::ROLE_CONTROLLER, "alice");
  message.mutable_open()->mutable_hold_end()->set_seconds(-1);
  EXPECT_EQ(refused_field(message), "hold_end");
  message = open_message(v1::ROLE_CONTROLLER, "alice");
  message.mutable_open()->set_priority(static_cast<v1::Priority>(9));
  EXPECT_EQ(refused_field(message), "priority");
  EXPECT_EQ(server.rig.sessions->controller(), "");
  EXPECT_EQ(server.rig.sessions->observers(), 0U);
}

TEST(SessionService, UnknownDeviceNamesTheKnown) {
  LiveServer server;
  auto message = open_message(v1::ROLE_OBSERVER, "alice");
  message.mutable_open()->set_device("no such thing");
  TestSession session(server.channel(), message);
  EXPECT_EQ(session.status().error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_NE(session.status().error_message().find("'rig'"), std::string::npos);
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

/// Looks at every tick: with the newest sample 200 ms old or older there is no elastic force, and
/// without a lease there is soon no command at all.
class SafetyWitness final : public server::RecordListener {
 public:
  void on_record(const core::TickRecord& record) override {
    const bool old = record.input.now - record.input.proxy.born >= 200ms;
    if (record.effort.tau_elastic[0] != 0.0) {
      pressed = true;
      violated = violated || old;
    }
    if (record.input.command.lease_held) lease_seen_ = record.input.now;
    const bool long_over = record.input.now - lease_seen_ >= 200ms;
    if (long_over && record.effort.tau_a[0] != 0.0) violated = true;
  }
  std::atomic<bool> pressed{false};
  std::atomic<bool> violated{false};

 private:
  core::TimePoint lease_seen_{};
};

/// Pressing, then `leave`: force must be gone in time and the lease free without anybody's help.
void expect_safe_after(const std::function<void(TestSession&)>& leave) {
  LiveServer server({{"127.0.0.1:0"}}, rig_config());
  SafetyWitness witness;
  server.rig.telemetry->add(0, &witness);
  TestSession observer(server.channel(), v1::ROLE_OBSERVER, "observer");
  OpenSession session(server.channel());
  ASSERT_TRUE(session.press());
  leave(session);
  ASSERT_TRUE(eventually([&] { return server.rig.newest().life.gain == 0.0; }));
  EXPECT_TRUE(eventually([&] { return server.rig.sessions->controller().empty(); }));
  EXPECT_TRUE(eventually([&] { return server.rig.device->force == 0.0; }));
  EXPECT_TRUE(eventually([&] { return observer.state().state() == v1::DEVICE_STATE_NAME_IDLE; }));
  OpenSession next(server.channel(), v1::ROLE_CONTROLLER, "bob");
  EXPECT_EQ(next.opened().lease_epoch(), 2U);
  server.rig.telemetry->remove(0, &witness);
  EXPECT_TRUE(witness.pressed);
  EXPECT_FALSE(witness.violated);
}

TEST(SessionService, CancelEndsForceAndLease) {
  expect_safe_after([](TestSession& session) { session.cancel(); });
}

TEST(SessionService, HalfCloseEndsForceAndLease) {
  expect_safe_after([](TestSession& session) { session.half_close(); });
}

TEST(SessionService, SilenceEndsForceAndLease) {
  expect_safe_after([](TestSession& session) { session.stop_streaming(); });
}

TEST(SessionService, ExpiredControllerContinuesAsObserver) {
  server::SessionRules rules{.lease_timeout = 500ms};
  LiveServer server({{"127.0.0.1:0"}}, rig_config(), rules);
  OpenSession session(server.channel());
  ASSERT_TRUE(eventually([&] { return session.heard(v1::Event::KIND_LEASE_EXPIRED); }));
  const std::size_t states = session.sequence().size();
  EXPECT_TRUE(eventually([&] { return session.sequence().size() > states + 20; }));
  session.publish({0.0, 0.0});
  EXPECT_TRUE(eventually([&] { return session.ack().rejected_old() == 1; }));
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

TEST(SessionService, LimitsSessionsAndFreesSlots) {
  LiveServer server({.listen = {"127.0.0.1:0"}, .max_sessions = 2});
  OpenSession first(server.channel(), v1::ROLE_OBSERVER, "1");
  {
    OpenSession second(server.channel(), v1::ROLE_OBSERVER, "2");
    TestSession third(server.channel(), v1::ROLE_OBSERVER, "3");
    EXPECT_EQ(refusal(third.status()),
              (Refusal{grpc::StatusCode::RESOURCE_EXHAUSTED, "TOO_MANY_SESSIONS"}));
    EXPECT_EQ(detail_of(third.status(), "limit"), "2");
  }
  EXPECT_TRUE(eventually([&] {
    TestSession again(server.channel(), v1::ROLE_OBSERVER, "4");
    return again.wait_opened();
  }));
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

TEST(SessionService, ShutdownEndsStreamsWithTheReason) {
  auto server = std::make_unique<LiveServer>();
  OpenSession session(server->channel());
  server.reset();
  EXPECT_EQ(session.status().error_code(), grpc::StatusCode::UNAVAILABLE);
}

}  // namespace
}  // namespace haptic::test
