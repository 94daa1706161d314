/// What the user's code may do inside a callback without holding up itself or another.

#include <gtest/gtest.h>

#include <atomic>

#include "haptic/client/client.hpp"
#include "tests/client/support/fake_server.hpp"

namespace haptic::test {
namespace {

using client::Connection;
using client::ErrorReason;

TEST(Callback, ReleaseInOnStateWaitsForNoEngage) {
  FakeServer server;
  server.hold_engage(true);
  std::atomic<client::Session*> mine{nullptr};
  std::atomic<bool> released{false};
  client::SessionOptions options;
  options.on_state = [&](const client::DeviceState&) {
    static_cast<void>(server.until([&] { return mine != nullptr; }));
    mine.load()->release();
    released = true;
  };
  const auto session = Connection(server.address()).open(options);
  mine = session.get();
  session->engage_when_ready();
  ASSERT_TRUE(server.until([&] { return server.heard().engages == 1; }));
  server.send_state(1);
  ASSERT_TRUE(server.until([&] { return released.load(); })) << "the callback waits for an answer";
  EXPECT_EQ(server.heard().releases, 1U);
  server.hold_engage(false);
  EXPECT_TRUE(server.until([&] { return server.heard().releases == 2; }))
      << "the force that the Engage brought afterwards stays on";
}

TEST(Callback, EngageAfterReleaseInOnStateCounts) {
  FakeServer server;
  server.hold_engage(true);
  std::atomic<client::Session*> mine{nullptr};
  std::atomic<bool> done{false};
  client::SessionOptions options;
  options.on_state = [&](const client::DeviceState& state) {
    static_cast<void>(server.until([&] { return mine != nullptr; }));
    if (state.seq != 1) return;
    mine.load()->release();
    mine.load()->engage_when_ready();
    done = true;
  };
  const auto session = Connection(server.address()).open(options);
  mine = session.get();
  session->engage_when_ready();
  ASSERT_TRUE(server.until([&] { return server.heard().engages == 1; }));
  server.send_state(1);
  ASSERT_TRUE(server.until([&] { return done.load(); }));
  server.hold_engage(false);
  EXPECT_TRUE(server.until([&] { return server.heard().engages >= 2; }))
      << "the last word was: engage";
  EXPECT_EQ(server.heard().releases, 1U);
}

TEST(Callback, TwoMayCloseTheSessionAtOnce) {
  FakeServer server;
  std::atomic<client::Session*> mine{nullptr};
  std::atomic<int> inside{0}, closed{0};
  const auto close_together = [&] {
    ++inside;
    static_cast<void>(server.until([&] { return mine != nullptr && inside == 2; }));
    mine.load()->close();
    ++closed;
  };
  client::SessionOptions options;
  options.on_state = [&](const client::DeviceState&) { close_together(); };
  options.on_event = [&](const client::Event&) { close_together(); };
  const auto session = Connection(server.address()).open(options);
  mine = session.get();
  server.send_state(1);
  server.send_event(v1::Event::KIND_STATE, "IDLE -> ARMED");
  EXPECT_TRUE(server.until([&] { return closed == 2; })) << "each waits for the other";
  EXPECT_FALSE(session->connected());
}

TEST(Callback, WaitingForAStateInOnStateIsRefused) {
  FakeServer server;
  std::atomic<client::Session*> mine{nullptr};
  std::atomic<bool> refused{false};
  client::SessionOptions options;
  options.on_state = [&](const client::DeviceState&) {
    static_cast<void>(server.until([&] { return mine != nullptr; }));
    const auto error = error_of([&] { return mine.load()->wait_for_state(); });
    refused = error.reason() == ErrorReason::kInvalidArgument;
  };
  const auto session = Connection(server.address()).open(options);
  mine = session.get();
  server.send_state(1);
  EXPECT_TRUE(server.until([&] { return refused.load(); }));
}

TEST(Opening, ANameMustBeUtf8) {
  FakeServer server;
  client::SessionOptions options;
  options.client_name = "\xFF";
  Connection connection(server.address());
  const auto error = error_of([&] { return connection.open(options); });
  EXPECT_EQ(error.reason(), ErrorReason::kInvalidArgument);
  EXPECT_NE(std::string(error.what()).find("UTF-8"), std::string::npos);
  EXPECT_TRUE(server.heard().openings.empty());
}

}  // namespace
}  // namespace haptic::test
