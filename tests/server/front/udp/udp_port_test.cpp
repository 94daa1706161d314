/// The port alone: true times of arrival, counters by reason, new keys.

#include "server/front/udp/udp_port.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "server/base/steady_now.hpp"
#include "server/front/udp/udp_socket.hpp"
#include "tests/proto/wire/channel_pair.hpp"
#include "tests/server/support/live_server.hpp"
#include "tests/server/support/port_of.hpp"
#include "tests/support/udp_end.hpp"

namespace haptic::test {
namespace {

class RecordingSink final : public server::UdpSink {
 public:
  struct Sample {
    std::uint64_t seq{0};
    core::TimePoint arrival{};
  };
  void on_udp_sample(const v1::ProxySample& sample, core::TimePoint arrival) override {
    const std::lock_guard lock(mutex_);
    samples_.push_back({sample.seq(), arrival});
  }
  void on_udp_change(wire::PathChange /*change*/) override {}
  void on_udp_keys(const wire::PathKeys& keys) override {
    const std::lock_guard lock(mutex_);
    keys_.push_back(keys);
  }
  [[nodiscard]] std::vector<Sample> samples() const {
    const std::lock_guard lock(mutex_);
    return samples_;
  }
  [[nodiscard]] std::vector<wire::PathKeys> keys() const {
    const std::lock_guard lock(mutex_);
    return keys_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Sample> samples_{};
  std::vector<wire::PathKeys> keys_{};
};

std::string sample(std::uint64_t seq) {
  v1::ProxySample message;
  message.set_seq(seq);
  message.set_mode(v1::PROXY_MODE_FREE);
  return message.SerializeAsString();
}

class UdpPortTest : public testing::Test {
 protected:
  std::shared_ptr<RecordingSink> sink = std::make_shared<RecordingSink>();
  server::UdpPort port{bound_udp("127.0.0.1:0")};
  server::UdpPort::Opened opened = port.open(sink, 10ms);
  /// Bytes to the port, from a socket that nobody answers.
  UdpEnd sender{wire::End::kServer, wire::fresh_keys()};
  TestEnd client{wire::End::kClient, opened.keys};

  wire::LinkCounters counters() {
    return opened.path->with([](const auto& end) { return end.counters(); });
  }
  bool path_in_use() {
    return opened.path->with([](const auto& end) { return end.in_use(); });
  }
};

TEST_F(UdpPortTest, WaitingInTheSocketAges) {
  // A kernel begins to stamp datagrams a moment after the first socket of the host asked for it.
  std::this_thread::sleep_for(200ms);
  // The port's thread is not there yet, as if the host had stopped it.
  sender.send_raw(client.seal(wire::DatagramType::kProxy, sample(1)), port.port());
  const core::TimePoint sent = server::steady_now();
  std::this_thread::sleep_for(100ms);
  port.start();
  ASSERT_TRUE(eventually([&] { return sink->samples().size() == 1; }));
  EXPECT_LT(sink->samples().front().arrival - sent, 50ms);
  EXPECT_GT(server::steady_now() - sink->samples().front().arrival, 100ms - 1ms);
}

TEST(UdpSocket, AClockStepAddsNoWait) {
  using server::believed_wait;
  EXPECT_EQ(believed_wait(3ms, 10ms), 3ms);
  EXPECT_EQ(believed_wait(5s + 3ms, 10ms), 10ms);  // stepped forward meanwhile
  EXPECT_EQ(believed_wait(3ms - 5s, 10ms), 10ms);  // stepped back
  EXPECT_EQ(believed_wait(0ms, 0ms), 0ms);
}

TEST_F(UdpPortTest, RejectionsAreCountedNeverAnswered) {
  port.start();
  UdpEnd forger{wire::End::kServer, wire::fresh_keys()};
  const ByteVector good = client.seal(wire::DatagramType::kProxy, sample(1));
  ByteVector magic = good, version = good, type = good, path = good, tag = good;
  magic[0] = 0;
  version[2] = 9;
  type[3] = 77;
  path[7] ^= 1U;
  tag.back() ^= 1U;
  for (const ByteVector& bytes :
       {ByteVector(31, 0), ByteVector(1201, 0), magic, version, type, path, tag}) {
    forger.send_raw(bytes, port.port());
  }
  ASSERT_TRUE(eventually([&] { return counters().rejections(wire::Rejection::kTag) == 1; }));
  const ByteVector unreadable = client.seal(wire::DatagramType::kProxy, "\xFF\xFF\xFF");
  for (const ByteVector& bytes : {unreadable, good, good}) sender.send_raw(bytes, port.port());
  ASSERT_TRUE(eventually([&] { return counters().duplicate() == 1; }));
  EXPECT_EQ(port.rejected(wire::Rejection::kLength), 2U);
  EXPECT_EQ(port.rejected(wire::Rejection::kMagic), 1U);
  EXPECT_EQ(port.rejected(wire::Rejection::kVersion), 1U);
  EXPECT_EQ(port.rejected(wire::Rejection::kType), 1U);
  EXPECT_EQ(port.rejected(wire::Rejection::kUnknownPath), 1U);
  EXPECT_EQ(counters().rejections(wire::Rejection::kTag), 1U);
  EXPECT_EQ(counters().rejections(wire::Rejection::kPayload), 1U);
  EXPECT_EQ(sink->samples().size(), 1U);
  // A replay from elsewhere, behind the genuine one.
  forger.send_raw(good, port.port());
  ASSERT_TRUE(eventually([&] { return counters().duplicate() == 2; }));
  // The address of the genuine one is challenged: so answers would be seen.
  ASSERT_TRUE(eventually([&] { return sender.arrivals() >= 5; }));
  EXPECT_EQ(forger.arrivals(), 0U);
}

TEST_F(UdpPortTest, TakesAWholeBurstInOrder) {
  for (std::uint64_t seq = 1; seq <= 300; ++seq) {
    sender.send_raw(client.seal(wire::DatagramType::kProxy, sample(seq)), port.port());
  }
  port.start();
  ASSERT_TRUE(eventually([&] { return sink->samples().size() == 300; }));
  std::uint64_t expected = 0;
  for (const auto& taken : sink->samples()) EXPECT_EQ(taken.seq, ++expected);
}

TEST_F(UdpPortTest, PathIdsDoNotPileUp) {
  port.start();
  for (int i = 0; i < 1000; ++i) port.rekey(opened.path);
  EXPECT_EQ(sink->keys().size(), 1000U);
  EXPECT_LE(port.path_ids(), 3U);
  sender.send_raw(client.seal(wire::DatagramType::kProxy, sample(1)), port.port());
  EXPECT_TRUE(
      eventually([&] { return sink->samples().size() == 1; }));  // the first keys still hold
  port.close(opened.path);
  EXPECT_EQ(port.path_ids(), 0U);
  port.rekey(opened.path);
  EXPECT_EQ(port.path_ids(), 0U);  // closed is closed
  EXPECT_EQ(sink->keys().size(), 1000U);
}

TEST_F(UdpPortTest, ClosedPathIsUnknownAndReported) {
  port.start();
  UdpEnd end(wire::End::kClient, opened.keys, port.port());
  ASSERT_TRUE(eventually([&] { return end.in_use() && path_in_use(); }));
  port.close(opened.path);
  ASSERT_TRUE(eventually([&] { return !end.in_use(); }));
  sender.send_raw(client.seal(wire::DatagramType::kProxy, sample(1)), port.port());
  ASSERT_TRUE(eventually([&] { return port.rejected(wire::Rejection::kUnknownPath) > 0; }));
  EXPECT_TRUE(sink->samples().empty());
}

}  // namespace
}  // namespace haptic::test
