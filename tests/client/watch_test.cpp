/// Telemetry without a session.

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>

#include "haptic/client/client.hpp"
#include "tests/client/support/fake_server.hpp"

namespace haptic::test {
namespace {

using client::Connection;

v1::WatchResponse state(std::uint64_t seq) {
  v1::WatchResponse message;
  message.mutable_state()->set_seq(seq);
  message.set_conflated(10 * seq);
  return message;
}

TEST(Watch, DeliversStatesAndEventsInOrderAndCountsWhatWasLeftOut) {
  FakeServer server;
  std::mutex mutex;
  std::vector<std::string> heard;
  const auto note = [&](const std::string& what) {
    const std::lock_guard lock(mutex);
    heard.push_back(what);
  };
  const auto watch =
      Connection(server.address())
          .watch(
              "finger", 25.0, [&](const client::DeviceState& s) { note(std::to_string(s.seq)); },
              [&](const client::Event& e) { note(e.reason); });
  ASSERT_TRUE(server.until([&] { return server.last_watch().rate_hz() == 25.0; }));
  EXPECT_EQ(server.last_watch().device(), "finger");
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
  EXPECT_EQ(watch->conflated(), 30U);
  EXPECT_TRUE(watch->running());
  EXPECT_FALSE(watch->error().has_value());
}

TEST(Watch, SaysWhyItEnded) {
  FakeServer server;
  const auto watch = Connection(server.address()).watch("finger", 25.0, {});
  ASSERT_TRUE(server.until([&] { return server.last_watch().rate_hz() == 25.0; }));
  server.end_watch(refusal(grpc::StatusCode::NOT_FOUND, "NO_SUCH_DEVICE", "no device"));
  ASSERT_TRUE(server.until([&] { return !watch->running(); }));
  const auto error = watch->error();
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->reason(), client::ErrorReason::kNoSuchDevice);
  EXPECT_EQ(error->server_reason(), "NO_SUCH_DEVICE");
}

TEST(Watch, AThrowingCallbackDoesNotEndIt) {
  FakeServer server;
  std::atomic<int> calls{0};
  const auto watch =
      Connection(server.address()).watch("finger", 25.0, [&](const client::DeviceState&) {
        ++calls;
        throw std::runtime_error("the user's");
      });
  ASSERT_TRUE(server.until([&] { return server.last_watch().rate_hz() == 25.0; }));
  server.send_watch(state(1));
  server.send_watch(state(2));
  EXPECT_TRUE(server.until([&] { return calls == 2; }));
  EXPECT_TRUE(watch->running());
}

TEST(Watch, EndsWhileTheServerSaysNothing) {
  FakeServer server;
  auto watch = Connection(server.address()).watch("finger", 25.0, {});
  ASSERT_TRUE(server.until([&] { return server.last_watch().rate_hz() == 25.0; }));
  watch.reset();  // a hang is ended by the test's own time limit
}

}  // namespace
}  // namespace haptic::test
