/// The rows of tests/relay/README.md#rows without a scenario file, over real sockets: connections
/// that are cut, clients that die or pause, the end of the server under load. The attacks on real
/// sockets are in tests/hostile.

#include <gtest/gtest.h>

#include <csignal>

#include "tests/relay/network_row.hpp"
#include "tests/relay/web_presser.hpp"

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

/// A client on a WebSocket, which is a process, 10 ms away. tests/system kills and stops one of
/// gRPC.
class NetworkProcess : public testing::Test {
 protected:
  void SetUp() override {
    if (!kHasWebPresser) GTEST_SKIP() << "the JavaScript client is not built";
  }
  static std::unique_ptr<Relay> way_of(const Daemon& daemon) {
    RelaySetup way = relay_to(daemon, "delay_10ms");
    way.tcp_port = daemon.web_port();
    return std::make_unique<Relay>(way);
  }
};

bool presses(RowRun& run, const WebPresser& client) {
  return run.must(within(60s, [&] { return client.pressing.load(); }), "pressed within a minute");
}

TEST_F(NetworkProcess, Killed) {
  network_row("web_client_killed", "contract; no force and IDLE in the end", [](RowRun& run) {
    {
      const auto relay = way_of(run.daemon());
      WebPresser client(run.daemon());
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
TEST_F(NetworkProcess, StoppedFor300Ms) {
  network_row("web_client_stopped_300ms",
              "contract; a process stopped as a whole: lost, and engaged again; exit 0",
              [](RowRun& run) {
                {
                  const auto relay = way_of(run.daemon());
                  WebPresser client(run.daemon());
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

TEST_F(NetworkProcess, ACutWebSocketIsResumed) {
  network_row("web_cut_connection", "contract; force back by itself, with the next lease epoch",
              [](RowRun& run) {
                {
                  // Begins first: it would keep the relay's sockets.
                  const WebPresser client(run.daemon());
                  auto relay = way_of(run.daemon());
                  if (!presses(run, client)) return;
                  relay.reset();
                  relay = way_of(run.daemon());
                  const auto resumed = [&] { return client.lease_epoch >= 2U && client.pressing; };
                  run.must(within(60s, resumed), "force back within a minute");
                  run.calm(client.lease_epoch == 2U, "lease epoch 2");
                  run.must(client.in_order(), "a sequence in use that never goes back");
                }
                run.got(run.judge().text());
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
