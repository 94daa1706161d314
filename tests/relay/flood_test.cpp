/// 100 000 datagrams per second: each is counted, none is answered. On a calm host the flood costs
/// no deadline that the same flood to a discarding socket does not cost, and a stop acts within 10
/// ms.

#include <gtest/gtest.h>

#include <algorithm>

#include "server/front/udp/udp_port.hpp"
#include "tests/relay/daemon.hpp"
#include "tests/relay/flood.hpp"
#include "tests/relay/host_stall.hpp"
#include "tests/relay/matrix_table.hpp"
#include "tests/relay/network_row.hpp"
#include "tests/relay/presser.hpp"
#include "tests/server/support/port_of.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

TEST(Flood, CountsEveryDatagramAndAnswersNone) {
  MatrixRow row("network/flood_counters",
                "sent = counted by reason + dropped by the kernel; no reply");
  constexpr std::uint64_t kEach = 200'000;
  server::UdpPort port(bound_udp("127.0.0.1:0"));
  const auto opened = port.open({}, 10ms);
  port.start();
  const auto counted = [&](wire::Rejection why) {
    return port.rejected(why) +
           opened.path->with([&](const auto& end) { return end.counters().rejections(why); });
  };
  const auto all = [&] {
    std::uint64_t sum = 0;
    for (std::size_t i = 1; i < wire::kRejections; ++i)
      sum += counted(static_cast<wire::Rejection>(i));
    return sum;
  };
  std::uint64_t short_or_long = 0;  // of the junk
  const auto packets = junk();
  for (std::uint64_t i = 0; i < kEach; ++i) {
    const std::size_t size = packets[i % packets.size()].size();
    short_or_long += size < 32 || size > wire::kLargestDatagram ? 1 : 0;
  }
  Flood first(port.port(), packets, kEach);
  EXPECT_TRUE(within(60s, [&] { return first.done(); }));
  Flood second(port.port(), headed(opened.keys.path_id), kEach);
  EXPECT_TRUE(within(60s, [&] { return second.done(); }));
  EXPECT_TRUE(within(10s, [&] { return all() + dropped_by_kernel(port.port()) == 2 * kEach; }));
  const std::uint64_t dropped = dropped_by_kernel(port.port());
  const std::uint64_t length = counted(wire::Rejection::kLength),
                      magic = counted(wire::Rejection::kMagic),
                      tag = counted(wire::Rejection::kTag);
  EXPECT_EQ(length + magic + tag, all());  // no other reason fits
  EXPECT_LE(length, short_or_long);
  EXPECT_LE(magic, kEach - short_or_long);
  EXPECT_LE(tag, kEach);
  EXPECT_GE(length + magic + tag + dropped, 2 * kEach);
  EXPECT_FALSE(first.answered());
  EXPECT_FALSE(second.answered());
  row.got(std::to_string(length) + " LENGTH; " + std::to_string(magic) + " MAGIC; " +
          std::to_string(tag) + " TAG; " + std::to_string(dropped) + " dropped by the kernel");
}

/// Effect of a flood of two seconds, or of several, on the loop and on stops.
struct Harm {
  double skipped{0.0};  ///< deadlines, per thousand ticks
  double rate{0.0};     ///< datagrams per second, as sent
  /// ms from the call to its answer, which the tick gives that latched
  std::vector<double> stops{};

  [[nodiscard]] double stop_p99() const {
    std::vector<double> sorted = stops;
    std::sort(sorted.begin(), sorted.end());
    return sorted.at(sorted.size() * 99 / 100 - 1);
  }
  [[nodiscard]] std::string text(const std::string& what) const {
    char line[140];
    std::snprintf(line, sizeof line,
                  "%s: %.2f of 1000 deadlines skipped, p99 of %zu stops %.2f ms at %.0f/s",
                  what.c_str(), skipped, stops.size(), stop_p99(), rate);
    return line;
  }
};

Harm measure(client::Connection& connection, std::uint16_t port, std::vector<Packet> packets) {
  constexpr int kStops = 100;
  Harm harm;
  Flood flood(port, std::move(packets));
  std::this_thread::sleep_for(200ms);
  const std::uint64_t sent = flood.sent();
  const auto begin = std::chrono::steady_clock::now();
  const client::ServerInfo before = connection.server_info();
  for (int i = 0; i < kStops; ++i) {
    const auto asked = std::chrono::steady_clock::now();
    connection.emergency_stop();
    harm.stops.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - asked)
            .count());
    connection.clear_fault();
    std::this_thread::sleep_for(20ms);
  }
  const client::ServerInfo after = connection.server_info();
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  harm.rate = static_cast<double>(flood.sent() - sent) / seconds;
  harm.skipped = 1000.0 * static_cast<double>(after.skipped_ticks - before.skipped_ticks) /
                 static_cast<double>(std::max<std::uint64_t>(1, after.ticks - before.ticks));
  flood.stop();
  EXPECT_FALSE(flood.answered());
  return harm;
}

/// The medians of the figures, and every stop.
Harm pooled(const std::vector<Harm>& harms) {
  const auto median = [&](double Harm::*figure) {
    std::vector<double> values;
    for (const Harm& harm : harms) values.push_back(harm.*figure);
    std::nth_element(values.begin(), values.begin() + static_cast<int>(values.size() / 2),
                     values.end());
    return values.at(values.size() / 2);
  };
  Harm all{median(&Harm::skipped), median(&Harm::rate)};
  for (const Harm& harm : harms) {
    all.stops.insert(all.stops.end(), harm.stops.begin(), harm.stops.end());
  }
  return all;
}

constexpr double kStopWithin = 10.0;  // ms, proto/README.md#a-session, p99
/// Two measurements of the same flood differ by at most this.
constexpr double kSkippedAlike = 0.5;  // deadlines per thousand ticks

struct FloodMeasurement {
  Harm discarded{}, junk{}, headed{};
  /// Deadlines skipped beyond `discarded`, per thousand ticks: the median of the rounds'
  /// differences, because the machine's other work is in both of a pair.
  double more_by_junk{0.0}, more_by_header{0.0};
};

FloodMeasurement five_rounds(const Daemon& daemon, const std::atomic<std::uint32_t>& path_id) {
  client::Connection connection(daemon.address());
  const DiscardingSocket discarding;
  std::vector<Harm> none, by_junk, by_header;  // alternating: the host's other work meets all alike
  for (int round = 0; round < 5; ++round) {
    none.push_back(measure(connection, discarding.port(), junk()));
    by_junk.push_back(measure(connection, daemon.udp_port(), junk()));
    by_header.push_back(measure(connection, daemon.udp_port(), headed(path_id)));
  }
  const auto more = [&](std::vector<Harm> harms) {
    for (std::size_t i = 0; i < harms.size(); ++i) harms[i].skipped -= none[i].skipped;
    return pooled(harms).skipped;
  };
  return {pooled(none), pooled(by_junk), pooled(by_header), more(by_junk), more(by_header)};
}

TEST(Flood, CostsNoDeadlineAndNoStop) {
  if (!host_is_calm()) GTEST_SKIP() << "times are judged under the label calm";
  MatrixRow row(
      "network/flood_100000_per_s",
      "no deadline skipped beyond what the flood to a discarding socket costs; EmergencyStop p99 "
      "<= 10 ms of the stops of five rounds; no reply");
  const HostStall host;
  Daemon daemon;
  ASSERT_TRUE(serves(daemon.address()));
  std::atomic<std::uint32_t> path_id{0};
  RelaySetup setup = relay_to(daemon, "clean");
  setup.attacker = [&](const Packet& packet) {
    path_id = wire::read_header(packet).header.path_id;
    return std::vector<Packet>{};
  };
  const Relay relay(setup);
  Presser presser(daemon.behind_relay());
  ASSERT_TRUE(within(60s, [&] { return presser.state().carrier == client::Carrier::kUdp; }));
  const FloodMeasurement measured = five_rounds(daemon, path_id);
  row.got(measured.discarded.text("discarded"));
  row.got(measured.junk.text("junk"));
  row.got(measured.headed.text("valid header"));
  row.got(host.text());
  EXPECT_LE(measured.more_by_junk, kSkippedAlike);
  EXPECT_LE(measured.more_by_header, kSkippedAlike);
  for (const Harm& harm : {measured.junk, measured.headed}) {
    EXPECT_LE(harm.stop_p99(), kStopWithin);
    EXPECT_GT(harm.rate, 80'000.0);
  }
  EXPECT_EQ(daemon.stop(), 0);
}

}  // namespace
}  // namespace haptic::test
