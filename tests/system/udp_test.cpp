/// Client library and server, both as shipped, over UDP.

#include <gtest/gtest.h>

#include <atomic>
#include <set>

#include "haptic/client/client.hpp"
#include "tests/server/support/live_server.hpp"

namespace haptic::test {
namespace {

using client::Carrier;
using client::Carriers;
using client::Lifecycle;
using client::Proxy;
using client::SessionOptions;

server::ServerScene with_udp() {
  return {.listen = {"127.0.0.1:0"}, .udp_listen = "127.0.0.1:0"};
}

/// Publishes every 10 ms until `condition`.
template <typename Condition>
bool while_publishing(client::Session& session, double a, Condition condition) {
  return eventually([&] {
    const bool force = session.state().gain > 0.0;  // which begins with a free proxy
    session.publish(force ? Proxy::held({a, 0.0}) : Proxy::free());
    std::this_thread::sleep_for(10ms);
    return condition();
  });
}

TEST(UdpEndToEnd, ForceIsFeltAndChangesReported) {
  LiveServer server(with_udp());
  client::Connection connection(server.address());
  std::mutex mutex;
  std::set<std::string> reasons;
  SessionOptions options{.nominal_rate_hz = 100.0};
  options.on_event = [&](const client::Event& event) {
    const std::lock_guard lock(mutex);
    reasons.insert(event.reason);
  };
  const auto session = connection.open(options);
  session->engage_when_ready();
  ASSERT_TRUE(while_publishing(*session, 0.01, [&] {
    const auto state = session->state();
    return state.state == Lifecycle::kEngaged && state.carrier == Carrier::kUdp &&
           std::abs(state.tau_a.at(0) - 1.0) < 1e-9;  // 0.01 m at 100 N/m
  }));
  EXPECT_TRUE(session->udp_link()->in_use);
  EXPECT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return reasons.count("SAMPLES GRPC -> UDP") == 1 && reasons.count("STATES GRPC -> UDP") == 1;
  }));
  EXPECT_EQ(session->statistics().rejected_invalid, 0U);
  // Nothing is lost on the way; of a session that paused, the newest goes.
  EXPECT_TRUE(eventually([&] {
    const auto counted = session->statistics();
    return counted.sent + counted.conflated == counted.published;
  }));
}

TEST(UdpEndToEnd, CarrierMakesNoDifferenceToForce) {
  LiveServer server(with_udp());
  client::Connection connection(server.address());
  std::atomic<double> least{1e9};
  std::atomic<bool> watching{false};
  SessionOptions options{.nominal_rate_hz = 100.0};
  options.on_state = [&](const client::DeviceState& state) {
    // At a lower gain this host was too busy to send in time.
    if (watching && state.gain == 1.0) least = std::min<double>(least, state.tau_a.at(0));
  };
  options.carriers = Carriers::kGrpcOnly;
  // The first session presses over the stream, the second by UDP.
  double by_stream = 0.0;
  {
    const auto session = connection.open(options);
    session->engage_when_ready();
    ASSERT_TRUE(while_publishing(*session, 0.01, [&] {
      return session->state().state == Lifecycle::kEngaged && session->state().gain == 1.0;
    }));
    EXPECT_EQ(session->state().carrier, Carrier::kGrpc);
    EXPECT_FALSE(session->udp_link());
    by_stream = session->state().tau_elastic.at(0);
  }
  options.carriers = Carriers::kAutomatic;
  const auto session = connection.open(options);
  session->engage_when_ready();
  ASSERT_TRUE(while_publishing(*session, 0.01, [&] {
    return session->state().state == Lifecycle::kEngaged && session->state().gain == 1.0;
  }));
  watching = true;
  ASSERT_TRUE(
      while_publishing(*session, 0.01, [&] { return session->state().carrier == Carrier::kUdp; }));
  for (int i = 0; i < 50; ++i) {
    session->publish(Proxy::held({0.01, 0.0}));
    std::this_thread::sleep_for(10ms);
  }
  EXPECT_NEAR(least, by_stream, 1e-9);
}

}  // namespace
}  // namespace haptic::test
