/// Things that the user's code may do inside a callback without holding up itself or another.

#include <atomic>

#include "tests/client/support/fake_server.hpp"

namespace haptic::test {
namespace {

/// Callbacks that use their own session.
class Callback : public WithServer {
 protected:
  void open_mine(client::SessionOptions options) {
    session = open(std::move(options));
    mine = session.get();
  }
  /// Returns once the callback is done, without an answer to the Engage under way.
  void call_back_while_engaging(const client::SessionOptions& options) {
    server.hold_engage(true);
    open_mine(options);
    session->engage_when_ready();
    ASSERT_TRUE(server.until([&] { return server.heard().engages == 1; }));
    server.send_state(1);
    ASSERT_TRUE(server.until([&] { return done.load(); })) << "the callback waits for an answer";
  }
  /// For a callback: the session, once open_mine() has it.
  client::Session& wait_for_mine() {
    static_cast<void>(server.until([&] { return mine != nullptr; }));
    return *mine;
  }

  // Things that callbacks use are declared before the session, which ends first.
  std::atomic<client::Session*> mine{nullptr};
  std::atomic<bool> done{false};
  std::atomic<int> inside{0}, closed{0};
  std::unique_ptr<client::Session> session;
};
using Opening = WithServer;
using client::ErrorReason;

TEST_F(Callback, ReleaseInCallbackDoesNotWait) {
  client::SessionOptions options;
  options.on_state = [&](const client::DeviceState&) {
    wait_for_mine().release();
    done = true;
  };
  call_back_while_engaging(options);
  EXPECT_EQ(server.heard().releases, 1U);
  server.hold_engage(false);
  EXPECT_TRUE(server.until([&] { return server.heard().releases == 2; }))
      << "the force that the Engage brought afterwards stays on";
}

TEST_F(Callback, EngageAfterReleaseInCallbackCounts) {
  client::SessionOptions options;
  options.on_state = [&](const client::DeviceState& state) {
    client::Session& own = wait_for_mine();
    if (state.seq != 1) return;
    own.release();
    own.engage_when_ready();
    done = true;
  };
  call_back_while_engaging(options);
  server.hold_engage(false);
  EXPECT_TRUE(server.until([&] { return server.heard().engages >= 2; }))
      << "the last word was: engage";
  EXPECT_EQ(server.heard().releases, 1U);
}

TEST_F(Callback, TwoMayCloseTheSession) {
  const auto close_together = [this] {
    ++inside;
    static_cast<void>(server.until([&] { return inside == 2; }));
    wait_for_mine().close();
    ++closed;
  };
  client::SessionOptions options;
  options.on_state = [close_together](const client::DeviceState&) { close_together(); };
  options.on_event = [close_together](const client::Event&) { close_together(); };
  open_mine(options);
  server.send_state(1);
  server.send_event(v1::Event::KIND_STATE, "IDLE -> ARMED");
  EXPECT_TRUE(server.until([&] { return closed == 2; })) << "each waits for the other";
  EXPECT_FALSE(session->connected());
}

TEST_F(Callback, WaitingInOnStateIsRefused) {
  client::SessionOptions options;
  options.on_state = [&](const client::DeviceState&) {
    client::Session& own = wait_for_mine();
    const auto error = error_of([&] { return own.wait_for_state(); });
    done = error.reason() == ErrorReason::kInvalidArgument;
  };
  open_mine(options);
  server.send_state(1);
  EXPECT_TRUE(server.until([&] { return done.load(); }));
}

TEST_F(Opening, ANameMustBeUtf8) {
  client::SessionOptions options{.client_name = "\xFF"};
  const auto error = error_of([&] { return open(options); });
  EXPECT_EQ(error.reason(), ErrorReason::kInvalidArgument);
  EXPECT_NE(std::string(error.what()).find("UTF-8"), std::string::npos);
  EXPECT_TRUE(server.heard().openings.empty());
}

}  // namespace
}  // namespace haptic::test
