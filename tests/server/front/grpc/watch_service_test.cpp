// Watching, and watching by many, over real sockets.
#include <gtest/gtest.h>

#include "tests/server/support/test_client.hpp"

namespace haptic::test {
namespace {

/// Reads one watch on its own thread.
class TestWatch {
 public:
  TestWatch(const std::shared_ptr<grpc::Channel>& channel, double rate_hz)
      : stub_(v1::HapticService::NewStub(channel)) {
    v1::WatchRequest request;
    request.set_rate_hz(rate_hz);
    reader_ = stub_->Watch(&context_, request);
    thread_ = std::thread([this] { read(); });
  }
  ~TestWatch() {
    context_.TryCancel();
    thread_.join();
    static_cast<void>(reader_->Finish());
  }
  [[nodiscard]] std::vector<std::uint64_t> sequence() {
    const std::lock_guard lock(mutex_);
    return sequence_;
  }
  [[nodiscard]] bool heard(v1::Event::Kind kind) {
    const std::lock_guard lock(mutex_);
    return std::any_of(events_.begin(), events_.end(),
                       [&](const v1::Event& e) { return e.kind() == kind; });
  }

 private:
  void read() {
    v1::WatchResponse message;
    while (reader_->Read(&message)) {
      const std::lock_guard lock(mutex_);
      if (message.has_event()) events_.push_back(message.event());
      if (message.has_state()) sequence_.push_back(message.state().seq());
    }
  }
  grpc::ClientContext context_;
  std::unique_ptr<v1::HapticService::Stub> stub_;
  std::unique_ptr<grpc::ClientReader<v1::WatchResponse>> reader_;
  std::mutex mutex_;
  std::vector<std::uint64_t> sequence_;
  std::vector<v1::Event> events_;
  std::thread thread_;
};

TEST(WatchService, StatesComeAtTheRequestedRate) {
  LiveServer server;
  TestWatch watch(server.channel(), 100.0);
  ASSERT_TRUE(eventually([&] { return watch.sequence().size() > 30; }));
  const auto sequence = watch.sequence();
  EXPECT_TRUE(std::is_sorted(sequence.begin(), sequence.end()));
  EXPECT_GE(sequence.back() - sequence.front() + 10, (sequence.size() - 1) * 10);
}

TEST(WatchService, EventsReachAWatcher) {
  LiveServer server;
  TestWatch watch(server.channel(), 1.0);
  ASSERT_TRUE(eventually([&] { return server.rig.sessions->observers() == 1; }));
  server.rig.sessions->emergency_stop("", [](const Outcome<Done>&) {});
  EXPECT_TRUE(eventually([&] { return watch.heard(v1::Event::KIND_FAULT); }));
}

TEST(WatchService, WatchesAreLimitedApartFromSessions) {
  LiveServer server({.listen = {"127.0.0.1:0"}, .max_sessions = 2});
  TestWatch first(server.channel(), 100.0), second(server.channel(), 100.0);
  ASSERT_TRUE(eventually([&] { return !first.sequence().empty() && !second.sequence().empty(); }));
  const auto stub = v1::HapticService::NewStub(server.channel());
  grpc::ClientContext context;
  const auto third = stub->Watch(&context, v1::WatchRequest{});
  v1::WatchResponse message;
  EXPECT_FALSE(third->Read(&message));
  const grpc::Status refused = third->Finish();
  EXPECT_EQ(refusal(refused), (Refusal{grpc::StatusCode::RESOURCE_EXHAUSTED, "TOO_MANY_SESSIONS"}));
  EXPECT_EQ(detail_of(refused, "limit"), "2");
  OpenSession session(server.channel());
}

TEST(WatchService, RefusesAWrongRate) {
  LiveServer server;
  const auto stub = v1::HapticService::NewStub(server.channel());
  grpc::ClientContext context;
  v1::WatchRequest request;
  request.set_rate_hz(0.5);
  EXPECT_EQ(field_of(stub->Watch(&context, request)->Finish()), "rate_hz");
  EXPECT_EQ(server.rig.sessions->observers(), 0U);
}

}  // namespace
}  // namespace haptic::test
