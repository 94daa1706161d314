/// Telemetry without a session.

#include <atomic>
#include <stdexcept>

#include "tests/client/support/fake_server.hpp"

namespace haptic::test {
namespace {

using Watch = WithServer;

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
  const auto watch = connection.watch(
      "finger", 25.0, [&](const client::DeviceState& s) { note(std::to_string(s.seq)); },
      [&](const client::Event& e) { note(e.reason); });
  ASSERT_TRUE(server.until([&] { return server.heard().watch.rate_hz() == 25.0; }));
  EXPECT_EQ(server.heard().watch.device(), "finger");
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

/// client/README.md, "Where the device can push": x = x_probe - W^{-1} n d / (n . W^{-1} n).
std::vector<double> onto_plane(const std::vector<double>& W, const std::vector<double>& x,
                               const std::vector<double>& n, double offset) {
  const double d = n[0] * x[0] + n[1] * x[1] - offset;
  const double along[2] = {W[2] * n[0] - W[1] * n[1], W[0] * n[1] - W[1] * n[0]};  // W^{-1} n det W
  const double scale = d / (n[0] * along[0] + n[1] * along[1]);
  return {x[0] - along[0] * scale, x[1] - along[1] * scale};
}

TEST_F(Watch, CouplingMetricProjectsOntoAPlane) {
  std::mutex mutex;
  std::vector<client::DeviceState> heard;
  const auto watch = connection.watch("finger", 25.0, [&](const client::DeviceState& s) {
    const std::lock_guard lock(mutex);
    heard.push_back(s);
  });
  ASSERT_TRUE(server.until([&] { return server.heard().watch.rate_hz() == 25.0; }));
  v1::WatchResponse message = state(1);
  v1::DeviceState& full = *message.mutable_state();
  full.mutable_certificate()->set_status(v1::CERTIFICATE_STATUS_COMPUTED);
  full.mutable_certificate()->set_margin(0.75);
  full.mutable_certificate()->set_block(2);
  v1::CouplingBlock& block = *full.add_coupling_metric();
  block.set_coordinates(2);
  for (const double w : {2.0, 1.0, 3.0}) block.add_lower(w);
  server.send_watch(message);
  server.send_watch(state(2));
  ASSERT_TRUE(server.until([&] {
    const std::lock_guard lock(mutex);
    return heard.size() == 2;
  }));
  ASSERT_TRUE(heard[0].certificate.has_value());
  EXPECT_EQ(heard[0].certificate->status, client::CertificateState::Status::kComputed);
  EXPECT_STREQ(client::name(heard[0].certificate->status), "COMPUTED");
  EXPECT_EQ(heard[0].certificate->margin, 0.75);
  EXPECT_EQ(heard[0].certificate->block, 2U);
  EXPECT_FALSE(heard[1].certificate.has_value());
  EXPECT_TRUE(heard[1].coupling_metric.empty());

  ASSERT_EQ(heard[0].coupling_metric.size(), 1U);
  EXPECT_EQ(heard[0].coupling_metric[0].coordinates, 2U);
  const std::vector<double>& W = heard[0].coupling_metric[0].lower;
  ASSERT_EQ(W.size(), 3U);
  const std::vector<double> x = onto_plane(W, {0.1, 0.2}, {1.0, 0.0}, 0.0);
  EXPECT_NEAR(x[0], 0.0, 1e-15);
  EXPECT_NEAR(x[1], 0.2 + 0.1 / 3.0, 1e-15);  // W^{-1} n = (3, -1) / 5
  const auto cost = [&W](double a, double b) {
    return W[0] * a * a + 2 * W[1] * a * b + W[2] * b * b;
  };
  for (const double aside : {-1e-3, 1e-3}) {
    EXPECT_LT(cost(x[0] - 0.1, x[1] - 0.2), cost(x[0] - 0.1, x[1] + aside - 0.2));
  }
}

TEST_F(Watch, SaysWhyItEnded) {
  const auto watch = connection.watch("finger", 25.0, {});
  ASSERT_TRUE(server.until([&] { return server.heard().watch.rate_hz() == 25.0; }));
  server.end_watch(refusal(grpc::StatusCode::NOT_FOUND, "NO_SUCH_DEVICE", "no device"));
  ASSERT_TRUE(server.until([&] { return !watch->running(); }));
  const auto error = watch->error();
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->reason(), client::ErrorReason::kNoSuchDevice);
  EXPECT_EQ(error->server_reason(), "NO_SUCH_DEVICE");
}

TEST_F(Watch, ThrowingCallbackDoesNotEndIt) {
  std::atomic<int> calls{0};
  const auto watch = connection.watch("finger", 25.0, [&](const client::DeviceState&) {
    ++calls;
    throw std::runtime_error("the user's");
  });
  ASSERT_TRUE(server.until([&] { return server.heard().watch.rate_hz() == 25.0; }));
  server.send_watch(state(1));
  server.send_watch(state(2));
  EXPECT_TRUE(server.until([&] { return calls == 2; }));
  EXPECT_TRUE(watch->running());
}

TEST_F(Watch, EndsWhileTheServerSaysNothing) {
  auto watch = connection.watch("finger", 25.0, {});
  ASSERT_TRUE(server.until([&] { return server.heard().watch.rate_hz() == 25.0; }));
  watch.reset();  // a hang is ended by the test's own time limit
}

}  // namespace
}  // namespace haptic::test
