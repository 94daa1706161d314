/// The rows of tests/relay/README.md#rows without a scenario file, over real sockets: an attacker
/// on the way, clients that die or pause, the end of the server under load. Other attacks and bad
/// numbers have their rows on virtual time, and tests/hostile sends them over real sockets.

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <limits>

#include "haptic/wire/datagram.hpp"
#include "tests/relay/flood.hpp"
#include "tests/relay/network_row.hpp"
#include "tests/relay/watched_client.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

bool engages_by_udp(RowRun& run, Presser& presser) {
  const bool engaged = within(60s, [&] {
    const auto state = presser.state();
    return state.state == client::Lifecycle::kEngaged && state.carrier == client::Carrier::kUdp;
  });
  return run.must(engaged, "engaged over UDP within a minute");
}

/// Datagrams that the server has rejected so far, for any reason up to the tag's check, in all
/// sessions and outside of them.
std::uint64_t rejected_datagrams(client::Connection& server) {
  std::uint64_t sum = 0;
  const auto add = [&sum](const std::vector<client::Rejected>& rejected) {
    for (const client::Rejected& each : rejected) {
      for (auto why = wire::Rejection::kLength; why <= wire::Rejection::kTag;
           why = static_cast<wire::Rejection>(static_cast<int>(why) + 1)) {
        if (each.reason == wire::name(why)) sum += each.count;
      }
    }
  };
  const client::LinkReport links = server.links();
  add(links.unassigned);
  for (const client::SessionLink& session : links.sessions) {
    for (const client::LinkCarrier& link : session.carriers) {
      if (link.carrier == client::Carrier::kUdp) add(link.up.rejected);
    }
  }
  return sum;
}

/// Every forged datagram is rejected by the server or dropped by the kernel, whose buffer is
/// finite. `before`: the counters before the attack.
void expect_rejected(RowRun& run, client::Connection& server, std::uint64_t before,
                     std::uint64_t forged) {
  run.must(forged > 100U, "more than 100 forged datagrams");
  // The last 100 ms may still be on their way.
  const double least = 0.9 * static_cast<double>(forged) - 20.0;
  std::uint64_t rejected = 0;
  const bool shown = within(20s, [&] {
    const std::uint64_t now = rejected_datagrams(server);
    rejected = now - std::min(now, before) + dropped_by_kernel(run.daemon().udp_port());
    return static_cast<double>(rejected) >= least;
  });
  run.must(shown, "nine of ten forged datagrams rejected, by the server's counters");
  run.got(std::to_string(forged) + " forged datagrams, " + std::to_string(rejected) + " rejected");
}

/// Damaged copies of every datagram during three seconds of pressing are rejected and counted. On a
/// calm host the user does not feel them: force stays, on UDP all along.
TEST(NetworkRow, BitFlips) {
  const char* const expected =
      "contract; forgeries rejected, by the server's counters; engaged throughout on UDP (calm "
      "host)";
  network_row("bit_flips", expected, [](RowRun& run) {
    std::atomic<bool> attacking{false};
    std::atomic<std::uint64_t> forged{0};
    {
      RelaySetup setup = relay_to(run.daemon(), "delay_10ms");
      setup.attacker = [&, random = Random(3)](const Packet& packet) mutable {
        std::vector<Packet> damaged(attacking ? 3 : 0, packet);
        for (Packet& copy : damaged) {
          copy[random.next() % copy.size()] ^= static_cast<std::uint8_t>(1U << random.next() % 8);
        }
        forged += damaged.size();
        return damaged;
      };
      const Relay relay(setup);
      Presser presser(run.daemon().behind_relay());
      if (!engages_by_udp(run, presser)) return;
      client::Connection server(run.daemon().address());
      const std::uint64_t before = rejected_datagrams(server);
      attacking = true;
      std::this_thread::sleep_for(3s);
      attacking = false;
      expect_rejected(run, server, before, forged);
      run.calm(!presser.heard("SAMPLES UDP -> GRPC"), "UDP all along");
      run.must(presser.in_order(), "a sequence in use that never goes back");
    }
    const RunFigures figures = run.judge();
    run.calm(figures.losses == 0, "force never lost");
    run.got(figures.text());
  });
}

TEST(NetworkRow, ACutConnectionIsResumed) {
  network_row("cut_connection",
              "contract; force back by itself; resumed within the lease "
              "(calm host)",
              [](RowRun& run) {
                {
                  auto relay = std::make_unique<Relay>(relay_to(run.daemon(), "clean"));
                  Presser presser(run.daemon().behind_relay());
                  if (!engages_by_udp(run, presser)) return;
                  relay.reset();  // both carriers
                  relay = std::make_unique<Relay>(relay_to(run.daemon(), "clean"));
                  run.calm(within(10s, [&] { return presser.heard("LEASE_RESUMED"); }),
                           "LEASE_RESUMED within 10 s");
                  run.calm(presser.session().lease_epoch() == 2U, "lease epoch 2");
                  engages_by_udp(run, presser);  // with new keys, on a new path
                  run.must(presser.in_order(), "a sequence in use that never goes back");
                }
                run.got(run.judge().text());
              });
}

/// A client that is a process: by gRPC the example, or on a WebSocket.
struct Kind {
  const char* name;
  double rate;  ///< Hz
  WatchedClient (*start)(const Daemon& daemon);
};

WatchedClient virtual_wall(const Daemon& daemon) {
  return {daemon,
          HAPTIC_BINARY_DIR "/client/haptic-example-virtual-wall",
          {"--server", daemon.behind_relay(), "--stop", "0.3"}};
}

class NetworkProcess : public testing::TestWithParam<Kind> {
 protected:
  void SetUp() override {
    if (!kHasWebPresser && kind().start == web_presser) {
      GTEST_SKIP() << "the JavaScript client is not built";
    }
  }
  [[nodiscard]] static const Kind& kind() { return GetParam(); }
  [[nodiscard]] static std::string row(const std::string& name) { return kind().name + name; }
};

bool presses(RowRun& run, const WatchedClient& client) {
  return run.must(within(60s, [&] { return client.pressing.load(); }), "pressed within a minute");
}

/// 10 ms away, by either carrier.
std::unique_ptr<Relay> way_of(const Kind& kind, const Daemon& daemon) {
  RelaySetup way = relay_to(daemon, "delay_10ms");
  if (kind.start == web_presser) way.tcp_port = daemon.web_port();
  return std::make_unique<Relay>(way);
}

TEST_P(NetworkProcess, Killed) {
  network_row(row("client_killed"), "contract; no force and IDLE in the end", [](RowRun& run) {
    run.client_rate(kind().rate);
    {
      const auto relay = way_of(kind(), run.daemon());
      WatchedClient client = kind().start(run.daemon());
      if (!presses(run, client)) return;
      client.process.signal(SIGKILL);
      client.process.wait();
      const auto idle = [&] {
        return client.watching.devices().front().state == client::Lifecycle::kIdle;
      };
      run.must(within(60s, idle), "IDLE after its lease");
    }
    const RunFigures figures = run.judge();
    run.must(run.record().back().tau_a == 0.0, "no force in the end");
    run.got(figures.text());
  });
}

/// The client's exit status is 0 only if SIGTERM finds it running.
TEST_P(NetworkProcess, StoppedFor300Ms) {
  network_row(row("client_stopped_300ms"),
              "contract; a process stopped as a whole: lost, and engaged again; exit 0",
              [](RowRun& run) {
                run.client_rate(kind().rate);
                {
                  const auto relay = way_of(kind(), run.daemon());
                  WatchedClient client = kind().start(run.daemon());
                  if (!presses(run, client)) return;
                  client.process.signal(SIGSTOP);
                  std::this_thread::sleep_for(300ms);
                  run.must(within(60s, [&] { return !client.pressing; }), "no force meanwhile");
                  client.process.signal(SIGCONT);
                  if (!presses(run, client)) return;
                  client.process.signal(SIGTERM);
                  run.must(client.process.wait() == 0, "the client's exit status 0");
                }
                const RunFigures figures = run.judge();
                run.must(figures.losses >= 1, "force lost");
                run.must(figures.engages >= 2, "engaged again");
                run.got(figures.text());
              });
}

INSTANTIATE_TEST_SUITE_P(By, NetworkProcess,
                         testing::Values(Kind{"", 200.0, virtual_wall},
                                         Kind{"web_", Presser::kRate, web_presser}),
                         [](const auto& test) { return *test.param.name ? "web" : "grpc"; });

TEST(NetworkRow, ACutWebSocketIsResumed) {
  if (!kHasWebPresser) GTEST_SKIP() << "the JavaScript client is not built";
  network_row("web_cut_connection", "contract; force back by itself, with the next lease epoch",
              [](RowRun& run) {
                {
                  const Kind kind{"", Presser::kRate, web_presser};
                  // Begins first: it would keep the relay's sockets.
                  const WatchedClient client = web_presser(run.daemon());
                  auto relay = way_of(kind, run.daemon());
                  if (!presses(run, client)) return;
                  relay.reset();
                  relay = way_of(kind, run.daemon());
                  const auto resumed = [&] { return client.lease_epoch >= 2U && client.pressing; };
                  run.must(within(60s, resumed), "force back within a minute");
                  run.calm(client.lease_epoch == 2U, "lease epoch 2");
                  run.must(client.in_order(), "a sequence in use that never goes back");
                }
                run.got(run.judge().text());
              });
}

/// A number that no proxy may have counts as silence, and force comes back by a ramp.
TEST(NetworkRow, NotANumber) {
  network_row("nan", "contract; refused and counted; lost, and engaged again", [](RowRun& run) {
    constexpr double kBad = std::numeric_limits<double>::quiet_NaN();
    std::uint64_t refused = 0;
    {
      const Relay relay(relay_to(run.daemon(), "delay_10ms"));
      Presser presser(run.daemon().behind_relay());
      if (!engages_by_udp(run, presser)) return;
      presser.instead = &kBad;
      run.must(within(60s, [&] { return presser.heard("LOST"); }), "LOST");
      presser.instead = nullptr;
      const auto counted = [&] { return presser.session().statistics().rejected_invalid; };
      run.must(within(60s, [&] { return counted() > 0U; }), "refusals counted");
      refused = counted();
      // The newest state here may still be the one with force.
      const auto engaged = [&] { return presser.state().state == client::Lifecycle::kEngaged; };
      if (run.must(within(60s, [&] { return !engaged(); }), "force given up")) {
        engages_by_udp(run, presser);
      }
    }
    const RunFigures figures = run.judge();
    run.must(figures.losses >= 1, "force lost");
    run.must(figures.engages >= 2, "engaged again");
    run.calm(figures.losses == 1, "force lost once");
    run.calm(refused >= 10U, "10 refused or more");  // 180 ms at 100 Hz, some still on the way
    run.got(figures.text());
    run.got(std::to_string(refused) + " refused");
  });
}

TEST(NetworkRow, SigtermUnderLoad) {
  network_row("sigterm_under_load", "contract; CLOSING without force; exit 0 within 5 s",
              [](RowRun& run) {
                const Relay relay(relay_to(run.daemon(), "loss_05"));
                Presser presser(run.daemon().behind_relay());
                if (!engages_by_udp(run, presser)) return;
                const auto before = std::chrono::steady_clock::now();
                static_cast<void>(run.record());
                run.calm(std::chrono::steady_clock::now() - before < 5s, "the end within 5 s");
                const RunFigures figures = run.judge();
                run.must(figures.last_state == "CLOSING", "CLOSING in the end");
                run.must(run.record().back().tau_a == 0.0, "no force in the end");
                run.got(figures.text());
              });
}

}  // namespace
}  // namespace haptic::test
