/// haptic-bench-crossing: what two processes cost against one. hapticd (an owner and a front) and
/// the same server in one process serve side by side; one client takes turns with them. From
/// publish() to the tick that uses the sample, and from the tick to the client's callback, by TCP
/// and by the UDP path. All times are of this host's steady clock.
///
///   haptic-bench-crossing HAPTICD        (--serve: the one process, which it starts itself)

#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "haptic/client/client.hpp"
#include "tests/bench/paired.hpp"
#include "tests/bench/percentile.hpp"
#include "tests/server/support/app.hpp"

namespace {

using namespace haptic;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr int kSamples = 250;  // per block, one in about 4 ms
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

/// up p50, p99; down p50, p99, in us.
std::vector<double> block(int port, client::Carriers carriers) {
  std::mutex mutex;
  std::vector<double> up, down;
  std::vector<std::int64_t> published;
  std::uint64_t used = 0;
  client::Connection connection("127.0.0.1:" + std::to_string(port));
  client::SessionOptions options;
  options.client_name = "bench";
  options.nominal_rate_hz = 250;
  options.state_rate_hz = 1000;
  options.carriers = carriers;
  options.on_state = [&](const client::DeviceState& state) {
    const std::int64_t now = now_ns();
    const std::lock_guard lock(mutex);
    down.push_back(static_cast<double>(now - state.server_time_ns) * 1e-3);
    if (state.proxy_seq_used == used || state.proxy_seq_used > published.size()) return;
    used = state.proxy_seq_used;
    const std::int64_t sent = published[used - 1];
    up.push_back(static_cast<double>(state.server_time_ns - sent) * 1e-3);
  };
  std::mt19937 random(static_cast<unsigned>(now_ns()));
  std::uniform_int_distribution<int> pause_us(3500, 4500);  // any phase of the tick
  {
    const auto session = connection.open(options);
    for (int i = 0; i < kSamples + 50; ++i) {
      std::this_thread::sleep_for(std::chrono::microseconds(pause_us(random)));
      if (i == 50) {  // the path is up
        const std::lock_guard lock(mutex);
        up.clear();
        down.clear();
      }
      {
        const std::lock_guard lock(mutex);
        published.push_back(now_ns());
      }
      session->publish(client::Proxy::held({0.4, 0.5}));
    }
    std::this_thread::sleep_for(20ms);
  }
  const std::lock_guard lock(mutex);
  return {bench::percentile(up, 0.5), bench::percentile(up, 0.99), bench::percentile(down, 0.5),
          bench::percentile(down, 0.99)};
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
    const auto rows = bench::compare_all(
        {"publish to tick p50" + by, "publish to tick p99" + by, "tick to callback p50" + by,
         "tick to callback p99" + by},
        "one process", "us", [&] { return block(two, carriers); },
        [&] { return block(one, carriers); });
    for (const bench::Row& row : rows) bench::print(row);
  }
  return 0;
}
