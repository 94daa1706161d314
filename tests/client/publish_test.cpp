/// Publishing: newest wins, numbers rise, the server's word reaches the statistics.

#include <cmath>
#include <thread>

#include "tests/client/support/fake_server.hpp"
#include "tests/support/message_text.hpp"

namespace haptic::test {
namespace {

using Publish = WithServer;
using client::Proxy;

/// Seq strictly rises; true also for none.
bool rising(const std::vector<v1::ProxySample>& samples) {
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (samples[i].seq() <= samples[i - 1].seq()) return false;
  }
  return true;
}

TEST_F(Publish, CarriesTheGivenSample) {
  const auto session = open();
  Proxy proxy = Proxy::held({0.25, -1.5});
  proxy.valid_for = std::chrono::microseconds(12345);
  proxy.device_seq_used = 77;
  const auto before = std::chrono::steady_clock::now().time_since_epoch();
  session->publish(proxy);
  const auto after = std::chrono::steady_clock::now().time_since_epoch();
  v1::ProxySample sample = first_sample();
  EXPECT_GE(std::chrono::nanoseconds(sample.source_time_ns()), before);
  EXPECT_LE(std::chrono::nanoseconds(sample.source_time_ns()), after);
  sample.clear_source_time_ns();
  expect_text(sample, R"(seq: 1 device_seq_used: 77 valid_for_us: 12345 mode: PROXY_MODE_HELD
                         position: [0.25, -1.5])");
}

TEST_F(Publish, MeasuresTheRoundTrip) {
  const auto session = open();
  session->publish(Proxy::free());
  EXPECT_EQ(session->round_trip().count(), 0);
  const auto published = std::chrono::steady_clock::now();
  static_cast<void>(first_sample());
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  v1::SessionResponse message;
  message.mutable_state()->set_seq(5);
  message.mutable_state()->set_proxy_seq_used(1);
  server.send(message);
  const auto received = session->wait_for_state().received;
  EXPECT_GE(session->round_trip(), std::chrono::milliseconds(5));
  EXPECT_GE(session->round_trip(), received - published);
}

TEST_F(Publish, NewestSampleReachesAStalledServer) {
  server.read_samples(false);
  const auto session = open();
  // 16 KiB each: 64 MiB in all, far more than flow control and sockets take in.
  constexpr std::uint64_t kSamples = 4096;
  for (std::uint64_t i = 1; i <= kSamples; ++i) {
    session->publish(Proxy::held(std::vector<double>(2048, static_cast<double>(i))));
  }
  server.read_samples(true);
  ASSERT_TRUE(server.until([&] {
    const auto samples = server.heard().samples;
    return !samples.empty() && samples.back().position(0) == static_cast<double>(kSamples);
  })) << "the newest sample never arrived";
  const auto samples = server.heard().samples;
  EXPECT_TRUE(rising(samples));
  EXPECT_LT(samples.size(), kSamples);
  EXPECT_TRUE(server.until([&] { return session->statistics().sent == samples.size(); }));
  const auto statistics = session->statistics();
  EXPECT_EQ(statistics.published, kSamples);
  EXPECT_EQ(statistics.sent + statistics.conflated, kSamples) << "every sample has one fate";
}

TEST_F(Publish, NumbersRiseFromAnyThread) {
  const auto session = open();
  constexpr int kThreads = 4, kEach = 2000;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < kEach; ++i) session->publish(Proxy::held({static_cast<double>(i)}));
    });
  }
  for (auto& thread : threads) thread.join();
  ASSERT_TRUE(server.until([&] {
    const auto s = session->statistics();
    return s.sent + s.conflated == kThreads * kEach && server.heard().samples.size() == s.sent;
  }));
  EXPECT_TRUE(rising(server.heard().samples));
}

TEST_F(Publish, TheServersCountsReachTheStatistics) {
  const auto session = open();
  v1::SessionResponse message;
  v1::SampleAck& ack = *message.mutable_ack();
  ack.set_accepted(11);
  ack.set_rejected_old(2);
  ack.set_rejected_invalid(3);
  ack.set_conflated_backlog(5);
  ack.set_last_rejection("position[0] = nan: must be finite");
  server.send(message);
  ASSERT_TRUE(server.until([&] { return session->statistics().accepted == 11; }));
  const auto statistics = session->statistics();
  EXPECT_EQ(statistics.rejected_old, 2U);
  EXPECT_EQ(statistics.rejected_invalid, 3U);
  EXPECT_EQ(statistics.backlog, 5U);
  EXPECT_EQ(statistics.last_rejection, "position[0] = nan: must be finite");
}

}  // namespace
}  // namespace haptic::test
