/// haptic-bench-network [--blocks N]: the proxy's age when a tick uses it, from publish() on,
/// behind the relay with 10 ms each way and losses of 0, 1, 5 and 10 %: by UDP and by WebSocket,
/// each against gRPC.
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <memory>
#include <stdexcept>
#include <thread>

#include "haptic/client/client.hpp"
#include "tests/bench/paired.hpp"
#include "tests/bench/web_client.hpp"
#include "tests/relay/relay.hpp"

namespace haptic::bench {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr double kRate = 100.0;  ///< Hz
constexpr milliseconds kPeriod{10}, kSettling{500}, kMeasured{2000};
constexpr std::uint64_t kPublished = (kSettling + kMeasured) / kPeriod;
/// Target for UDP: the delay and three periods.
constexpr double kTargetUs = 10'000.0 + 3 * 10'000.0;

/// The relay's link in block `block`: the scenario with a seed of its own.
test::RelaySetup setup(const test::Scenario& scenario, int block, std::uint16_t tcp,
                       std::uint16_t udp) {
  test::RelaySetup relay;
  relay.scenario = scenario;
  relay.scenario.seed += 1000U * static_cast<std::uint64_t>(block);
  relay.tcp_port = tcp;
  relay.udp_port = udp;
  return relay;
}

/// Waits until samples go by the carrier that is to be measured.
void settle(const client::Session& session, bool by_udp) {
  const auto give_up = Clock::now() + std::chrono::seconds(20);
  const auto ready = [&] {
    const auto link = session.udp_link();
    return !by_udp || (link && link->in_use);
  };
  while (!ready()) {
    if (Clock::now() > give_up) throw std::runtime_error("the UDP path never came into use");
    std::this_thread::sleep_for(milliseconds(5));
  }
}

enum class By { kGrpc, kUdp, kWebSocket };

/// Writer of a sample; the one with number n is the n-th.
using Publish = std::function<void(std::uint64_t n)>;

/// A session by the relay's address, as long as the answer lives.
Publish open(const std::string& address, By carrier) {
  if (carrier == By::kWebSocket) {
    const auto client = std::make_shared<WebClient>(address);
    client->control(kRate);
    return [client](std::uint64_t n) { client->write(sample(n)); };
  }
  struct Held {
    explicit Held(const std::string& server) : connection(server) {}
    ~Held() {
      if (session) session->close();
    }
    client::Connection connection;
    std::unique_ptr<client::Session> session{};
  };
  const bool by_udp = carrier == By::kUdp;
  const auto held = std::make_shared<Held>(address);
  client::SessionOptions options;
  options.client_name = "bench";
  options.nominal_rate_hz = kRate;
  options.carriers = by_udp ? client::Carriers::kUdpOnly : client::Carriers::kGrpcOnly;
  held->session = held->connection.open(options);
  settle(*held->session, by_udp);
  return [held](std::uint64_t) { held->session->publish(client::Proxy::held({0.4, 0.5})); };
}

/// Age in us of what each tick used, from publish() on, in one block.
std::vector<double> ages(Product& product, const test::RelaySetup& trouble, By carrier) {
  const test::Relay relay(trouble);
  Publish publish = open("127.0.0.2:" + std::to_string(trouble.tcp_port), carrier);
  product.arrivals.restart();
  const auto begin = (Clock::now() + kSettling).time_since_epoch().count();
  const auto published = paced(kPublished, kPeriod, publish);
  publish = nullptr;
  const std::lock_guard lock(product.arrivals.mutex);
  std::vector<At> used = product.arrivals.used;
  std::erase_if(used, [&](const At& one) { return one.second < begin; });
  std::vector<double> answer = ways_us(used, published);
  // If the path was down all the time, the newest sample is at least as old as the block.
  if (answer.empty()) answer.push_back(core::seconds(kSettling + kMeasured) * 1e6);
  return answer;
}

void one_loss(Product& product, const test::Scenario& scenario, int blocks) {
  int block = 0;
  const auto by = [&](By carrier) {
    return [&, carrier] {
      const std::uint16_t tcp = test::port_of(product.address(carrier == By::kWebSocket ? 1 : 0));
      const auto values = ages(product, setup(scenario, ++block, tcp, product.udp_port()), carrier);
      return std::vector<double>{percentile(values, 0.5), percentile(values, 0.99)};
    };
  };
  for (const auto& [carrier, word] : {std::pair(By::kUdp, "UDP"), {By::kWebSocket, "WebSocket"}}) {
    char name[80];
    std::snprintf(name, sizeof name, "proxy age at use by %s 10 ms %g %% loss", word,
                  scenario.up.loss * 100.0);
    const std::string what = name;
    const auto rows = compare_all({what + " p50", what + " p99"}, "gRPC", "us", by(carrier),
                                  by(By::kGrpc), blocks);
    for (const Row& row : rows) print(row);
    if (carrier == By::kUdp) print(Figure{what + " p99", "us", rows.back().own, kTargetUs});
  }
}

void age_at_use(int blocks) {
  const BenchWeb web;
  Product product({"127.0.0.1:0"}, "127.0.0.1:0", nullptr, web.config());
  for (const char* file : {"delay_10ms", "loss_01", "loss_05", "loss_10"}) {
    one_loss(product, test::shipped_scenario(file), blocks);
  }
}

}  // namespace
}  // namespace haptic::bench

int main(int argc, char** argv) {
  int blocks = 20;
  CLI::App cli("haptic-bench-network - the proxy's age at use, by UDP and WebSocket against gRPC");
  cli.add_option("--blocks", blocks, "alternations; of fewer than 20 nothing may be quoted")
      ->check(CLI::Range(2, 1000));
  CLI11_PARSE(cli, argc, argv);
  spdlog::set_level(spdlog::level::warn);  // sessions that come and go
  haptic::bench::print_header();
  try {
    haptic::bench::age_at_use(blocks);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic-bench-network: %s\n", error.what());
    return 1;
  }
  return 0;
}
