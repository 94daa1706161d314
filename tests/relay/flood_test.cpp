/// 100 000 datagrams per second: none is answered. On a calm host the flood costs no deadline that
/// the same flood to a discarding socket does not cost, and a stop acts within 10 ms.

#include <gtest/gtest.h>

#include "haptic/wire/datagram.hpp"
#include "tests/relay/daemon.hpp"
#include "tests/relay/flood.hpp"
#include "tests/relay/matrix_table.hpp"
#include "tests/relay/network_row.hpp"
#include "tests/relay/presser.hpp"
#include "tests/support/percentile.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

/// Effect of a flood of two seconds, or of several, on the loop and on stops.
struct Harm {
  double skipped{0.0};  ///< deadlines, per thousand ticks
  double rate{0.0};     ///< datagrams per second, as sent
  /// ms from the call to its answer, which the tick gives that latched
  std::vector<double> stops{};

  [[nodiscard]] double stop_p99() const { return percentile(stops, 0.99); }
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
  harm.skipped =
      1000.0 * static_cast<double>(after.loop.skipped - before.loop.skipped) /
      static_cast<double>(std::max<std::uint64_t>(1, after.loop.ticks - before.loop.ticks));
  flood.stop();
  EXPECT_FALSE(flood.answered());
  return harm;
}

/// The medians of the figures, and every stop.
Harm pooled(const std::vector<Harm>& harms) {
  const auto median = [&](double Harm::*figure) {
    std::vector<double> values;
    for (const Harm& harm : harms) values.push_back(harm.*figure);
    return percentile(values, 0.5);
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
