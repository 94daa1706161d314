/// Sessions that survive their stream, and what is known of their links, over real sockets.

#include <gtest/gtest.h>

#include "tests/server/support/test_client.hpp"

namespace haptic::test {
namespace {

v1::SessionRequest opening(const std::string& name, const std::string& resume = {}) {
  v1::SessionRequest message = open_message(v1::ROLE_CONTROLLER, name);
  message.mutable_open()->set_resumable(true);
  message.mutable_open()->set_resume(resume);
  return message;
}

TEST(ResumeService, OnlyResumingNeedsNoFreePlace) {
  const server::ServerScene one_place{.listen = {"127.0.0.1:0"}, .max_sessions = 1};
  LiveServer server(one_place), other(one_place);
  OpenSession first(server.channel(), opening("alice")), not_resumable(other.channel());
  OpenSession second(server.channel(), opening("alice", first.opened().session_id()));
  EXPECT_TRUE(second.opened().resumed());
  EXPECT_EQ(refusal(first.status()), (Refusal{grpc::StatusCode::ABORTED, "RESUMED"}));
  EXPECT_EQ(server.rig.sessions->controller(), "alice");
  TestSession refused(other.channel(), opening("alice", not_resumable.opened().session_id()));
  EXPECT_EQ(reason_of(refused.status()), "TOO_MANY_SESSIONS");
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
