// Bounds on what one peer may cost, over real sockets.
#include <gtest/gtest.h>

#include "tests/server/support/test_client.hpp"

namespace haptic::test {
namespace {

TEST(Bounds, ObserversLeaveAControllersPlace) {
  LiveServer server({.listen = {"127.0.0.1:0"}, .max_sessions = 1});
  OpenSession observer(server.channel(), v1::ROLE_OBSERVER, "observer");
  TestSession second(server.channel(), v1::ROLE_OBSERVER, "one too many");
  EXPECT_EQ(refusal(second.status()),
            (Refusal{grpc::StatusCode::RESOURCE_EXHAUSTED, "TOO_MANY_SESSIONS"}));
  EXPECT_EQ(detail_of(second.status(), "limit"), "1");
  OpenSession controller(server.channel());
  EXPECT_FALSE(observer.ended());
  observer.cancel();
  EXPECT_TRUE(eventually([&] {
    TestSession again(server.channel(), v1::ROLE_OBSERVER, "takes its place");
    return again.wait_opened();
  }));
}

TEST(Bounds, FormerControllersGiveWay) {
  const server::SessionRules rules{.lease_timeout = 500ms};
  LiveServer server({.listen = {"127.0.0.1:0"}, .max_sessions = 2}, patient_config(), rules);
  OpenSession first(server.channel());
  ASSERT_TRUE(eventually([&] { return first.heard(v1::Event::KIND_LEASE_EXPIRED); }));
  EXPECT_FALSE(first.ended());
  OpenSession second(server.channel());
  ASSERT_TRUE(eventually([&] { return second.heard(v1::Event::KIND_LEASE_EXPIRED); }));
  EXPECT_EQ(reason_of(first.status()), "TOO_MANY_SESSIONS");
  OpenSession third(server.channel());
}

TEST(Bounds, CompressedRequestsAreRefused) {
  LiveServer server;
  const auto stub = v1::HapticService::NewStub(server.channel());
  grpc::ClientContext context;
  context.set_compression_algorithm(GRPC_COMPRESS_GZIP);
  v1::EmergencyStopRequest request;
  request.set_reason(std::string(4'000, 'x'));
  v1::EmergencyStopResponse response;
  EXPECT_EQ(stub->EmergencyStop(&context, request, &response).error_code(),
            grpc::StatusCode::UNIMPLEMENTED);
}

TEST(Bounds, ACutConnectionComesAgain) {
  server::ServiceLimits limits;
  limits.connections.debt = 16 * 1024;
  LiveServer server({{"127.0.0.1:0"}}, patient_config(), {}, limits);
  const auto channel = server.channel();
  OpenSession session(channel);
  session.publish(std::vector<double>(20'000, 0.0));  // beyond every message: a debt
  ASSERT_TRUE(session.wait_ended());
  EXPECT_TRUE(eventually([&] { return server.rpc.connections().second >= 1; }));
  EXPECT_TRUE(eventually([&] {
    TestSession again(channel, v1::ROLE_OBSERVER, "again");
    return again.wait_opened();
  }));
}

TEST(Bounds, ShutdownWaitsForNoPeer) {
  auto server = std::make_unique<LiveServer>();
  const auto stub = v1::HapticService::NewStub(server->channel());
  grpc::ClientContext context;
  // Reads none of its states.
  const auto watch = stub->Watch(&context, [] {
    v1::WatchRequest request;
    request.set_rate_hz(1000);
    return request;
  }());
  std::this_thread::sleep_for(300ms);
  const auto begin = std::chrono::steady_clock::now();
  server->rpc.stop(1s);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
  context.TryCancel();
}

}  // namespace
}  // namespace haptic::test
