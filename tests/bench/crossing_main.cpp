/// haptic-bench-crossing: what two processes cost against one. hapticd (an owner and a front) and
/// the same server in one process serve side by side; one client takes turns with them, by TCP and
/// by the UDP path. All times are of this host's steady clock. Three figures:
///
/// - publish to mailbox: how long before a tick publish() must be called for a half, or 99 %, of
///   the samples to be used by that tick. Samples published at any time would wait 0 to 1 ms for
///   their tick, in which some us are not seen.
/// - tick to callback: from the tick to the client's callback with its state.
/// - tick: from the loop's wake-up to the tick's end, over the last 10 s. The loop of two processes
///   takes samples in it.
///
///   haptic-bench-crossing HAPTICD        (--serve: the one process, which it starts itself)

#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <sys/wait.h>
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
#include "tests/bench/paired.hpp"
#include "tests/bench/percentile.hpp"
#include "tests/server/support/app.hpp"

namespace {

using namespace haptic;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr int kSamples = 700;  // per block, one in about 3 ms, for two leads in turn
constexpr std::int64_t kTickNs = 1'000'000;
const std::string kScene = HAPTIC_SOURCE_DIR "/server/scenes/finger_constant.textproto";

std::vector<std::string> settings(int port) {
  return {"loop.late_bucket_full=1000000",
          "server.listen=[\"127.0.0.1:" + std::to_string(port) + "\"]",
          "server.udp_listen=\"127.0.0.1:" + std::to_string(port) + "\""};
}

int serve(int port) {
  sigset_t end;
  sigemptyset(&end);
  sigaddset(&end, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &end, nullptr);
  spdlog::set_level(spdlog::level::warn);
  test::App app(server::load_scene(kScene, settings(port)), {server::RealtimeMode::kTry});
  app.start();
  int signal = 0;
  sigwait(&end, &signal);
  app.stop();
  return 0;
}

class Server {
 public:
  explicit Server(const std::vector<std::string>& command) : id_(fork()) {
    if (id_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    std::vector<char*> words;
    for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    execv(words[0], words.data());
    _exit(127);
  }
  ~Server() {
    kill(id_, SIGTERM);
    waitpid(id_, nullptr, 0);
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

 private:
  pid_t id_;
};

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
  double us_{400.0};
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
    return first_ + kTickNs * tick + static_cast<std::int64_t>(bench::percentile(phases, 0.5));
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

/// In us: publish to mailbox p50, p99; tick to callback p50, p99; tick p50. `leads` go on from
/// block to block.
std::vector<double> block(int port, client::Carriers carriers, std::array<Lead, 2>& leads) {
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
  for (std::uint64_t seq = 1; seq <= kSamples; ++seq) {
    if (seq == 50) ticks.take_waits_us();
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
  std::vector<double> waits = ticks.take_waits_us();
  return {sums[0] / counts[0], sums[1] / counts[1], bench::percentile(waits, 0.5),
          bench::percentile(waits, 0.99), connection.server_info().tick_p50_us};
}

void wait_until_served(int port) {
  for (int i = 0; i < 100; ++i) {
    std::this_thread::sleep_for(100ms);
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
  if (argc == 3 && std::strcmp(argv[1], "--serve") == 0) return serve(std::stoi(argv[2]));
  if (argc != 2) return 2;
  const int one = 20'000 + getpid() % 5'000, two = one + 5'000;
  const Server one_process({"/proc/self/exe", "--serve", std::to_string(one)});
  std::vector<std::string> command{argv[1], "--scene", kScene, "--log-level", "warn"};
  for (const std::string& setting : settings(two)) {
    command.emplace_back("--set");
    command.push_back(setting);
  }
  const Server two_processes(command);
  for (const int port : {one, two}) wait_until_served(port);
  bench::print_header();
  for (const auto carriers : {client::Carriers::kGrpcOnly, client::Carriers::kAutomatic}) {
    const std::string by = carriers == client::Carriers::kAutomatic ? " (UDP)" : " (stream)";
    using Leads = std::array<Lead, 2>;
    Leads leads_one{Lead(0.5, 8.0), Lead(0.99, 50.0)}, leads_two = leads_one;
    const auto rows = bench::compare_all(
        {"publish to mailbox p50" + by, "publish to mailbox p99" + by, "tick to callback p50" + by,
         "tick to callback p99" + by, "tick p50" + by},
        "one process", "us", [&] { return block(two, carriers, leads_two); },
        [&] { return block(one, carriers, leads_one); });
    for (const bench::Row& row : rows) bench::print(row);
  }
  return 0;
}
