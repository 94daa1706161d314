/// Sessions that survive their stream, and sessions that are taken over, over real sockets.

#include <gtest/gtest.h>

#include "tests/server/support/test_client.hpp"

namespace haptic::test {
namespace {

v1::SessionRequest opening(const std::string& name, const std::string& resume = {},
                           v1::Priority priority = v1::PRIORITY_UNSPECIFIED) {
  v1::SessionRequest message = open_message(v1::ROLE_CONTROLLER, name);
  message.mutable_open()->set_resumable(true);
  message.mutable_open()->set_resume(resume);
  message.mutable_open()->set_priority(priority);
  return message;
}

std::ptrdiff_t times_heard(TestSession& session, const std::string& reason) {
  const auto events = session.events();
  return std::count_if(events.begin(), events.end(),
                       [&](const v1::Event& event) { return event.reason() == reason; });
}

bool heard(TestSession& session, const std::string& reason) {
  return times_heard(session, reason) > 0;
}

TEST(ResumeService, ForceContinuesAfterALostStream) {
  LiveServer server;
  OpenSession watcher(server.channel(), v1::ROLE_OBSERVER, "watcher");
  auto first = std::make_unique<TestSession>(server.channel(), opening("alice"));
  ASSERT_TRUE(first->wait_opened());
  EXPECT_FALSE(first->opened().resumed());
  ASSERT_TRUE(first->press());
  const std::string former = first->opened().session_id();
  first->stop_streaming();
  const std::uint64_t newest = first->seq;
  first->cancel();
  ASSERT_TRUE(eventually([&] { return heard(watcher, "LEASE_DETACHED"); }));
  EXPECT_EQ(watcher.state().state(), v1::DEVICE_STATE_NAME_ENGAGED);  // hold_end is 5 s here

  OpenSession second(server.channel(), opening("alice", former));
  EXPECT_TRUE(second.opened().resumed());
  EXPECT_EQ(second.opened().lease_epoch(), 2U);
  EXPECT_EQ(second.opened().newest_seq(), newest);
  EXPECT_NE(second.opened().session_id(), former);
  second.seq = newest;
  second.stream(0.01);
  ASSERT_TRUE(eventually([&] { return second.ack().accepted() > 10; }));
  ASSERT_TRUE(eventually([&] { return second.state().lease_epoch() == 2U; }));
  EXPECT_EQ(second.state().gain(), 1.0);
  EXPECT_TRUE(eventually([&] { return heard(watcher, "LEASE_RESUMED"); }));
  EXPECT_FALSE(heard(watcher, "ENGAGED -> RELEASING"));
}

TEST(ResumeService, MissedEventsAreToldOnce) {
  LiveServer server;
  OpenSession watcher(server.channel(), v1::ROLE_OBSERVER, "watcher");
  auto first = std::make_unique<OpenSession>(server.channel(), opening("alice"));
  ASSERT_TRUE(eventually([&] { return heard(*first, "LEASE_GRANTED"); }));
  v1::SessionRequest again = opening("alice", first->opened().session_id());
  again.mutable_open()->set_events_after_ns(first->events().back().server_time_ns());
  first->cancel();
  ASSERT_TRUE(eventually([&] { return heard(watcher, "LEASE_DETACHED"); }));
  server.rig.sessions->emergency_stop("", [](const Outcome<Done>&) {});
  ASSERT_TRUE(eventually([&] { return heard(watcher, "EMERGENCY_STOP"); }));

  OpenSession second(server.channel(), again), stranger(server.channel(), v1::ROLE_OBSERVER, "bob");
  ASSERT_TRUE(eventually([&] { return heard(second, "LEASE_RESUMED"); }));
  EXPECT_EQ(times_heard(second, "LEASE_DETACHED"), 1);
  EXPECT_EQ(times_heard(second, "EMERGENCY_STOP"), 1);
  EXPECT_EQ(times_heard(second, "LEASE_GRANTED"), 0);
  EXPECT_EQ(times_heard(stranger, "EMERGENCY_STOP"), 0);
}

TEST(ResumeService, FormerStreamIsEnded) {
  LiveServer server;
  OpenSession first(server.channel(), opening("alice"));
  OpenSession second(server.channel(), opening("alice", first.opened().session_id()));
  EXPECT_TRUE(second.opened().resumed());
  EXPECT_EQ(refusal(first.status()), (Refusal{grpc::StatusCode::ABORTED, "RESUMED"}));
  EXPECT_EQ(server.rig.sessions->controller(), "alice");
}

server::ServerScene places(unsigned max_sessions) {
  return {.listen = {"127.0.0.1:0"}, .max_sessions = max_sessions};
}

TEST(ResumeService, ResumingNeedsNoFreePlace) {
  LiveServer server(places(1));
  OpenSession first(server.channel(), opening("alice"));
  TestSession stranger(server.channel(), v1::ROLE_CONTROLLER, "stranger");
  EXPECT_EQ(reason_of(stranger.status()), "TOO_MANY_SESSIONS");
  EXPECT_EQ(detail_of(stranger.status(), "limit"), "1");
  OpenSession second(server.channel(), opening("alice", first.opened().session_id()));
  EXPECT_TRUE(second.opened().resumed());
  ASSERT_TRUE(first.wait_ended());
}

TEST(ResumeService, FailedResumeOpensNoPlace) {
  LiveServer server(places(1));
  TestSession first(server.channel());  // not resumable
  ASSERT_TRUE(first.wait_opened());
  TestSession second(server.channel(), opening("alice", first.opened().session_id()));
  EXPECT_EQ(reason_of(second.status()), "TOO_MANY_SESSIONS");
}

TEST(ResumeService, FarewellEndsTheLeaseAtOnce) {
  LiveServer server;
  OpenSession session(server.channel(), opening("alice"));
  v1::SessionRequest farewell;
  farewell.mutable_leave();
  ASSERT_TRUE(session.send(farewell));
  EXPECT_TRUE(session.status().ok());
  EXPECT_EQ(server.rig.sessions->controller(), "");
}

TEST(ResumeService, OperatorTakesOverAndHolderLearns) {
  LiveServer server;
  OpenSession alice(server.channel());
  ASSERT_TRUE(alice.press());
  OpenSession boss(server.channel(), opening("boss", "", v1::PRIORITY_OPERATOR));
  EXPECT_EQ(boss.opened().lease_epoch(), 2U);
  ASSERT_TRUE(eventually([&] { return heard(alice, "LEASE_PREEMPTED"); }));
  EXPECT_FALSE(alice.ended()) << "it goes on as an observer";
  EXPECT_EQ(reason_of(alice.engage()), "NOT_CONTROLLER");
  ASSERT_TRUE(eventually([&] { return alice.ack().rejected_old() > 0; }));
  TestSession bob(server.channel(), opening("bob", "", v1::PRIORITY_PRIMARY));
  EXPECT_EQ(reason_of(bob.status()), "LEASE_HELD");
  EXPECT_EQ(detail_of(bob.status(), "holder"), "boss");
  EXPECT_EQ(detail_of(bob.status(), "priority"), "operator");
}

TEST(ResumeService, AClampIsAnEvent) {
  LiveServer server;
  OpenSession alice(server.channel());
  grpc::ClientContext context;
  v1::UpdateSettingsRequest request;
  v1::UpdateSettingsResponse response;
  request.set_session_id(alice.opened().session_id());
  request.add_stiffness(500.0);
  ASSERT_TRUE(alice.stub().UpdateSettings(&context, request, &response).ok());
  EXPECT_TRUE(eventually([&] { return alice.heard(v1::Event::KIND_CLAMP); }));
}

v1::GetLinkStatsResponse link_stats(LiveServer& server, const std::string& device = {}) {
  const auto stub = v1::HapticService::NewStub(server.channel());
  grpc::ClientContext context;
  v1::GetLinkStatsRequest request;
  v1::GetLinkStatsResponse response;
  request.set_device(device);
  EXPECT_TRUE(stub->GetLinkStats(&context, request, &response).ok());
  return response;
}

/// A step of a client that says which state it used, by the clock `offset` ahead of this process's.
void publish_step(TestSession& session, std::chrono::nanoseconds offset,
                  std::chrono::milliseconds delay = {}) {
  v1::SessionRequest message;
  v1::ProxySample& sample = *message.mutable_proxy();
  sample.set_seq(++session.seq);
  sample.set_mode(v1::PROXY_MODE_FREE);
  sample.set_device_seq_used(session.state().seq());
  sample.set_source_time_ns((server::steady_now().time_since_epoch() + offset).count());
  sample.set_hold_us(1);
  std::this_thread::sleep_for(delay);  // on its way
  session.send(message);
}

TEST(LinkStatsService, ReportsRoundTripClockAgeRefusals) {
  LiveServer server;
  OpenSession alice(server.channel());
  ASSERT_TRUE(eventually([&] { return alice.state().seq() > 0; }));
  constexpr std::chrono::nanoseconds kOffset = 1h;
  for (int i = 0; i < 50; ++i) {
    publish_step(alice, kOffset);
    std::this_thread::sleep_for(5ms);
  }
  alice.publish({std::nan(""), 0.0});
  ASSERT_TRUE(eventually([&] { return alice.ack().rejected_invalid() == 1; }));
  const v1::GetLinkStatsResponse answer = link_stats(server);
  ASSERT_EQ(answer.sessions_size(), 1);
  const v1::SessionLink& link = answer.sessions(0);
  EXPECT_EQ(link.device(), "rig");
  EXPECT_EQ(link.client_name(), "alice");
  EXPECT_TRUE(link.holds_lease());
  EXPECT_EQ(link.samples_by(), v1::TRANSPORT_GRPC);
  EXPECT_EQ(link.states_by(), v1::TRANSPORT_GRPC);
  ASSERT_EQ(link.transports_size(), 1);
  const v1::LinkTransport& stream = link.transports(0);
  EXPECT_EQ(stream.up().received(), 51U);
  ASSERT_EQ(stream.up().rejected_size(), 1);
  EXPECT_EQ(stream.up().rejected(0).reason(), "NOT_FINITE");
  EXPECT_TRUE(stream.has_round_trip());
  ASSERT_TRUE(link.has_clock());
  const auto bound = std::chrono::seconds(link.clock().bound().seconds()) +
                     std::chrono::nanoseconds(link.clock().bound().nanos());
  EXPECT_LE(std::chrono::abs(std::chrono::nanoseconds(link.clock().offset_ns()) - kOffset), bound);
  EXPECT_TRUE(link.has_age_p99());
  EXPECT_EQ(answer.DebugString().find(alice.opened().session_id()), std::string::npos);
  EXPECT_EQ(link_stats(server, "rig").sessions_size(), 1);
}

TEST(LinkStatsService, AnUnknownDeviceIsNamed) {
  LiveServer server;
  const auto stub = v1::HapticService::NewStub(server.channel());
  grpc::ClientContext context;
  v1::GetLinkStatsRequest request;
  v1::GetLinkStatsResponse response;
  request.set_device("thumb");
  const grpc::Status status = stub->GetLinkStats(&context, request, &response);
  EXPECT_EQ(refusal(status), (Refusal{grpc::StatusCode::NOT_FOUND, "NO_SUCH_DEVICE"}));
}

TEST(LinkStatsService, DelayedSampleKeepsItsAge) {
  LiveServer server;
  OpenSession alice(server.channel());
  ASSERT_TRUE(eventually([&] { return alice.state().seq() > 0; }));
  for (int i = 0; i < 50; ++i) {
    publish_step(alice, 1h);
    std::this_thread::sleep_for(5ms);
  }
  publish_step(alice, 1h, 500ms);
  ASSERT_TRUE(eventually([&] { return alice.state().proxy_seq_used() == alice.seq; }));
  EXPECT_GE(alice.state().proxy_age_us(), 300'000U);
  EXPECT_GE(link_stats(server).sessions(0).aged_by_clock(), 1U);
}

}  // namespace
}  // namespace haptic::test
