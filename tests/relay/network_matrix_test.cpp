/// Every scenario of tests/relay/README.md#rows over real sockets: hapticd as a process, the client
/// library or a client on a WebSocket, the relay between them, and the record of every tick.
///
/// The scenarios of the client's clock are not here: nothing between the ends can turn a process's
/// clock. tests/interop/clock_rows_test.py has a client that turns its own.

#include <gtest/gtest.h>

#include <memory>
#include <tuple>

#include "tests/relay/network_row.hpp"
#include "tests/relay/web_presser.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

bool is_one_of(const std::string& name, std::initializer_list<const char*> names) {
  return std::any_of(names.begin(), names.end(), [&](const char* one) { return name == one; });
}

/// Force stays on from Engage to the end on a calm host: what is lost or late is less than the
/// ladder allows. By TCP alone, what is lost comes 200 ms later, and so does all that follows.
bool is_never_felt(const std::string& name, bool web) {
  if (is_one_of(name, {"loss_01", "loss_05", "burst_8ms", "tcp_blocked"})) return !web;
  return is_one_of(name, {"clean", "delay_1ms", "delay_10ms", "delay_30ms", "delay_100ms",
                          "duplicate_100", "reorder_25", "jitter_1ms", "jitter_1ms_in_order",
                          "jitter_5ms", "jitter_5ms_in_order", "udp_blocked", "narrow"});
}

/// The UDP path gives up if every third packet is lost, and a stream hardly moves, or ends because
/// its keep-alive is not answered. Force may never be granted; it must be safe if it is.
bool may_be_refused(const std::string& name) {
  return name == "loss_30";
}

/// Silence above 180 ms on the way to the server, which ends before the scenario does.
bool is_lost_and_back(const std::string& name, bool web) {
  if (name == "tcp_blocked") return web;
  return is_one_of(name, {"partition_1s_up", "partition_10s_up", "stall_backlog"});
}

std::string expectation(const std::string& name, bool web) {
  std::string text =
      "levels and gain by age; seq never back; force moves by at most the slew limit; no elastic "
      "force 200 ms after the last sample; energy within the tank; no fault";
  if (is_never_felt(name, web)) text += "; engaged throughout (calm host)";
  if (is_lost_and_back(name, web)) text += "; lost, and engaged again";
  if (name == "udp_blocked" && !web) text += "; falls back to gRPC and returns to UDP";
  return text;
}

std::vector<Scenario> scenarios() {
  std::vector<Scenario> all = shipped_scenarios();
  std::erase_if(all, [](const Scenario& s) { return s.name.rfind("clock_", 0) == 0; });
  return all;
}

/// A client that presses; null: it could open no session before `end`.
std::unique_ptr<Presser> presser_of(RowRun& run, const std::string& name,
                                    std::chrono::steady_clock::time_point end) {
  for (;;) {
    try {
      return std::make_unique<Presser>(run.daemon().behind_relay());
    } catch (const client::ClientError&) {
      if (!may_be_refused(name)) throw;
      if (std::chrono::steady_clock::now() > end) return nullptr;
    }
  }
}

/// A client presses through the scenario, from its first packet to its end.
void press_through(RowRun& run, const Scenario& scenario) {
  const std::string& name = scenario.name;
  const Relay relay(relay_to(run.daemon(), scenario));
  const auto end = std::chrono::steady_clock::now() + scenario.duration;
  const std::unique_ptr<Presser> open = presser_of(run, name, end);
  if (!open) return;
  Presser& presser = *open;
  std::this_thread::sleep_until(end);
  const auto engaged = [&] { return presser.state().state == client::Lifecycle::kEngaged; };
  const auto by_udp = [&] { return presser.state().carrier == client::Carrier::kUdp; };
  // A client that was cut off may still wait for its longest retransmission and back-off.
  if (!may_be_refused(name)) run.must(within(60s, engaged), "engaged within a minute of the end");
  run.must(presser.in_order(), "a sequence in use that never goes back");
  if (name == "udp_blocked") {
    run.must(presser.heard("SAMPLES UDP -> GRPC"), "a fallback to gRPC");
  }
  if (is_never_felt(name, false)) run.must(within(60s, by_udp), "samples by UDP in the end");
}

/// The same by a WebSocket.
void press_by_web(RowRun& run, const Scenario& scenario) {
  RelaySetup way = relay_to(run.daemon(), scenario);
  way.tcp_port = run.daemon().web_port();
  const Relay relay(way);
  const WebPresser presser(run.daemon());
  std::this_thread::sleep_for(scenario.duration);
  const auto engaged = [&] { return presser.engaged.load(); };
  if (!may_be_refused(scenario.name)) {
    run.must(within(60s, engaged), "engaged within a minute of the end");
  }
  run.must(presser.in_order(), "a sequence in use that never goes back");
}

/// The rows by the client library, or on a WebSocket.
class NetworkMatrix : public testing::TestWithParam<std::tuple<Scenario, bool>> {};

TEST_P(NetworkMatrix, TheContractHoldsAtEveryTick) {
  const auto& [scenario, web] = GetParam();
  if (web && !kHasWebPresser) GTEST_SKIP() << "the JavaScript client is not built";
  const std::string& name = scenario.name;
  const auto press = web ? press_by_web : press_through;
  const bool by_web = web;
  network_row((web ? "web_" : "") + name, expectation(name, web), [&](RowRun& run) {
    press(run, scenario);
    const RunFigures figures = run.judge();
    run.must(run.record().size() > 1000U, "more than 1000 ticks recorded");
    run.must(figures.engaged || may_be_refused(name), "engaged at some time");
    run.calm(figures.losses == 0 || !is_never_felt(name, by_web), "force never lost");
    run.must((figures.losses >= 1 && figures.engages >= 2) || !is_lost_and_back(name, by_web),
             "force lost, and back");
    run.got(figures.text());
  });
}

INSTANTIATE_TEST_SUITE_P(Shipped, NetworkMatrix,
                         testing::Combine(testing::ValuesIn(scenarios()), testing::Bool()),
                         [](const auto& test) {
                           return std::get<0>(test.param).name +
                                  (std::get<1>(test.param) ? "_web" : "");
                         });

}  // namespace
}  // namespace haptic::test
