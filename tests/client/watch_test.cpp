/// Telemetry without a session.

#include <atomic>

#include "tests/client/support/fake_server.hpp"

namespace haptic::test {
namespace {

class Watch : public WithServer {
 protected:
  /// Returns once the server heard of it.
  [[nodiscard]] std::unique_ptr<client::Watch> watch(
      std::function<void(const client::DeviceState&)> on_state,
      std::function<void(const client::Event&)> on_event = {}) {
    auto begun = connection.watch("finger", 25.0, std::move(on_state), std::move(on_event));
    EXPECT_TRUE(server.until([&] { return server.heard().watch.rate_hz() == 25.0; }));
    EXPECT_EQ(server.heard().watch.device(), "finger");
    return begun;
  }
};

v1::WatchResponse state(std::uint64_t seq) {
  v1::WatchResponse message;
  message.mutable_state()->set_seq(seq);
  message.set_conflated(10 * seq);
  return message;
}

TEST_F(Watch, DeliversInOrderAndCountsOmissions) {
  std::mutex mutex;
  std::vector<std::string> heard;
  const auto note = [&](const std::string& what) {
    const std::lock_guard lock(mutex);
    heard.push_back(what);
  };
  const auto watching = watch([&](const client::DeviceState& s) { note(std::to_string(s.seq)); },
                              [&](const client::Event& e) { note(e.reason); });
  server.send_watch(state(1));
  v1::WatchResponse event;
  event.mutable_event()->set_reason("DEVICE_SILENT");
  event.set_conflated(10);
  server.send_watch(event);
  server.send_watch(state(3));
  ASSERT_TRUE(server.until([&] {
    const std::lock_guard lock(mutex);
    return heard.size() == 3;
  }));
  EXPECT_EQ(heard, (std::vector<std::string>{"1", "DEVICE_SILENT", "3"}));
  EXPECT_EQ(watching->conflated(), 30U);
  EXPECT_TRUE(watching->running());
  EXPECT_FALSE(watching->error().has_value());
}

TEST_F(Watch, SaysWhyItEnded) {
  const auto watching = watch({});
  server.end_watch(refusal(grpc::StatusCode::NOT_FOUND, "NO_SUCH_DEVICE", "no device"));
  ASSERT_TRUE(server.until([&] { return !watching->running(); }));
  const auto error = watching->error();
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->reason(), client::ErrorReason::kNoSuchDevice);
  EXPECT_EQ(error->server_reason(), "NO_SUCH_DEVICE");
}

TEST_F(Watch, EndsWhileTheServerSaysNothing) {
  auto watching = watch({});
  watching.reset();  // a hang is ended by the test's own time limit
}

}  // namespace
}  // namespace haptic::test
