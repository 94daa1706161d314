/// haptic-bench-crossing: what two processes cost against one. hapticd's server runs as owner and
/// front, or in one process; in each block a fresh one serves one client, by the stream and then by
/// the UDP path, and nothing else runs. All times are of this host's steady clock. Figures:
///
/// - publish to mailbox: how long before a tick publish() must be called for a half, or 99 %, of
///   the samples to be used by that tick. Samples published at any time would wait 0 to 1 ms for
///   their tick, in which some us are not seen.
/// - tick to callback: from the tick to the client's callback with its state.
/// - tick: from the loop's wake-up to the device's command, while the client publishes. The loop of
///   two processes takes samples in it. The bell that wakes the telemetry rings after the command:
///   the device does not wait for it.
///
/// The loop has the last core for itself, as server/README.md advises.
///
///   haptic-bench-crossing FRONT      the program hapticd-front

#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "haptic/client/client.hpp"
#include "tests/bench/crossing_servers.hpp"
#include "tests/bench/paired.hpp"
#include "tests/support/percentile.hpp"

namespace {

using namespace haptic;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr int kBlocks = 40;
constexpr int kSamples = 380;  // per block and carrier, one in about 3 ms, for two leads in turn
constexpr std::int64_t kTickNs = 1'000'000;
const std::string kScene = HAPTIC_SOURCE_DIR "/server/scenes/finger_constant.textproto";

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch())
      .count();
}

/// The time before a tick at which a share of the samples is in time for it. It grows with each
/// sample that is late and shrinks with each that is in time, so that both balance at that share.
class Lead {
 public:
  Lead(double share, double step_us) : share_(share), step_us_(step_us) {}
  void judge(bool in_time) { us_ += step_us_ * (in_time ? share_ - 1.0 : share_); }
  [[nodiscard]] double us() const { return us_; }
  [[nodiscard]] std::int64_t ns() const { return static_cast<std::int64_t>(1e3 * us_); }

 private:
  double share_, step_us_;
  double us_{200.0};
};

/// The newest states of one session: which sample each tick used, and when the next tick is due.
class Ticks {
 public:
  void add(const client::DeviceState& state) {
    const std::int64_t now = now_ns();
    const std::lock_guard lock(mutex_);
    if (first_ == 0) first_ = state.server_time_ns;
    phases_.push_back(state.server_time_ns - first_ - kTickNs * number(state.server_time_ns));
    if (phases_.size() > 100) phases_.pop_front();
    used_[number(state.server_time_ns)] = state.proxy_seq_used;
    waits_us_.push_back(static_cast<double>(now - state.server_time_ns) * 1e-3);
  }
  /// Number of the first tick that is at least `ahead` ns away. 0: no state came yet.
  std::int64_t next(std::int64_t ahead) {
    const std::lock_guard lock(mutex_);
    if (first_ == 0) return 0;
    return number(now_ns() + ahead + kTickNs / 2) + 1;
  }
  /// When it is due: ticks start late now and then, and their median does not.
  std::int64_t due_ns(std::int64_t tick) {
    const std::lock_guard lock(mutex_);
    std::vector<double> phases(phases_.begin(), phases_.end());
    return first_ + kTickNs * tick + static_cast<std::int64_t>(test::percentile(phases, 0.5));
  }
  /// The newest sample that this tick had used; none: its state did not come.
  std::optional<std::uint64_t> used_by(std::int64_t tick) {
    const std::lock_guard lock(mutex_);
    const auto found = used_.find(tick);
    return found == used_.end() ? std::nullopt : std::optional(found->second);
  }
  std::vector<double> take_waits_us() {
    const std::lock_guard lock(mutex_);
    return std::exchange(waits_us_, {});
  }

 private:
  [[nodiscard]] std::int64_t number(std::int64_t time_ns) const {
    return static_cast<std::int64_t>(
        std::floor(static_cast<double>(time_ns - first_) / kTickNs + 0.5));
  }
  std::mutex mutex_{};
  std::int64_t first_{0};
  std::deque<std::int64_t> phases_{};
  std::map<std::int64_t, std::uint64_t> used_{};
  std::vector<double> waits_us_{};
};

/// Two leads that go on from block to block: for a half and for 99 % of the samples.
using Leads = std::array<Lead, 2>;

/// In us: publish to mailbox p50, p99; tick to callback p50, p99; tick p50, and without read().
std::vector<double> measure(const bench::ServerProcess& server, int port, client::Carriers carriers,
                            Leads& leads) {
  Ticks ticks;
  client::Connection connection("127.0.0.1:" + std::to_string(port));
  client::SessionOptions options;
  options.client_name = "bench";
  options.nominal_rate_hz = 333;
  options.state_rate_hz = 1000;
  options.carriers = carriers;
  options.on_state = [&](const client::DeviceState& state) { ticks.add(state); };
  const auto session = connection.open(options);
  do std::this_thread::sleep_for(300ms);  // the UDP path is up as well
  while (ticks.next(0) == 0);
  std::array<double, 2> sums{}, counts{};
  std::uint64_t first_tick = 0;
  for (std::uint64_t seq = 1; seq <= kSamples; ++seq) {
    if (seq == 30) {
      ticks.take_waits_us();
      first_tick = server.times().count.load();
    }
    Lead& lead = leads[seq % 2];
    const std::int64_t tick = ticks.next(lead.ns());
    const std::int64_t at = ticks.due_ns(tick) - lead.ns();
    std::this_thread::sleep_until(Clock::time_point(std::chrono::nanoseconds(at) - 100us));
    while (now_ns() < at) continue;
    session->publish(client::Proxy::held({0.4, 0.5}));
    std::this_thread::sleep_for(1500us + std::chrono::nanoseconds(lead.ns()));
    const auto used = ticks.used_by(tick);
    if (!used) continue;
    lead.judge(*used >= seq);
    sums[seq % 2] += lead.us();
    ++counts[seq % 2];
  }
  const std::array<double, 2> tick = server.times().p50_us(first_tick);
  const std::vector<double> waits = ticks.take_waits_us();
  return {sums[0] / counts[0],
          sums[1] / counts[1],
          test::percentile(waits, 0.5),
          test::percentile(waits, 0.99),
          tick[0],
          tick[1]};
}

void wait_until_served(int port) {
  for (int i = 0; i < 500; ++i) {
    std::this_thread::sleep_for(20ms);
    try {
      client::Connection connection("127.0.0.1:" + std::to_string(port));
      if (connection.healthy("", 1s)) return;
    } catch (const client::ClientError&) {
      continue;  // not yet
    }
  }
  throw std::runtime_error("a server does not serve");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc >= 5 && std::strcmp(argv[1], "--serve") == 0) {
    const int cpu = std::stoi(argv[4]);
    return bench::serve(kScene, std::stoi(argv[2]), std::stoi(argv[3]),
                        cpu < 0 ? std::nullopt : std::optional(cpu), argc > 5 ? argv[5] : "");
  }
  if (argc != 2) return 2;
  const std::optional<int> loop_cpu = bench::leave_a_core_to_the_loop();
  const std::string front = argv[1];
  int port = 20'000 + getpid() % 5'000;
  const auto block = [&port, loop_cpu](const std::string& program, std::array<Leads, 2>& leads) {
    const bench::ServerProcess server(++port, loop_cpu, program);
    wait_until_served(port);
    std::vector<double> all = measure(server, port, client::Carriers::kGrpcOnly, leads[0]);
    const auto by_udp = measure(server, port, client::Carriers::kAutomatic, leads[1]);
    all.insert(all.end(), by_udp.begin(), by_udp.end());
    return all;
  };
  const std::vector<std::pair<std::string, double>> figures{
      {"publish to mailbox p50", 10.0},
      {"publish to mailbox p99", 30.0},
      {"tick to callback p50", 10.0},
      {"tick to callback p99", 30.0},
      {"tick p50", 0.1},
      {"tick without the simulated finger p50", 0.1}};
  std::vector<std::string> what;
  for (const char* by : {" (stream)", " (UDP)"}) {
    for (const auto& figure : figures) what.push_back(figure.first + by);
  }
  const Leads start{Lead(0.5, 8.0), Lead(0.99, 50.0)};
  std::array<Leads, 2> leads_one{start, start}, leads_two{start, start};
  std::vector<bench::Row> rows = bench::compare_all(
      what, "one process", "us", [&] { return block(front, leads_two); },
      [&] { return block("", leads_one); }, kBlocks, bench::Pairs::kDifference);
  bench::print_header(bench::Pairs::kDifference);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].target = figures[i % figures.size()].second;
    bench::print(rows[i]);
  }
  return 0;
}
