/// haptic-bench-wire: one way from publish() to the mailbox and from the tick to the client's
/// callback, against a bare gRPC stream of the same messages on the same host; and the controller's
/// proxy age next to 16 watchers at 1 kHz. All times are of this host's steady clock.
#include <grpcpp/grpcpp.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdio>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/bench/one_way.hpp"
#include "tests/bench/paired.hpp"
#include "tests/server/support/scripted_device.hpp"
#include "tests/support/angles.hpp"

namespace {

using namespace haptic;
using namespace haptic::bench;
using std::chrono::milliseconds;

struct Ages {
  double p99_us{0.0};
  double skipped{0.0};
};

/// The controller's proxy age at use over 1 s at 500 Hz, next to `watchers` at 1 kHz.
Ages ages_block(Product& product, int watchers) {
  client::Connection connection(product.address());
  std::vector<std::unique_ptr<client::Connection>> others;
  std::vector<std::unique_ptr<client::Watch>> watches;
  for (int i = 0; i < watchers; ++i) {
    others.push_back(std::make_unique<client::Connection>(product.address()));
    watches.push_back(others.back()->watch("finger", 1000.0, [](const client::DeviceState&) {}));
  }
  client::SessionOptions options;
  options.client_name = "bench";
  options.nominal_rate_hz = 500;
  const auto session = connection.open(options);
  paced(600, milliseconds(2), [&](std::uint64_t i) {
    session->publish(client::Proxy::held({0.4, 0.5}));
    if (i == 100) product.arrivals.restart();
  });
  const std::lock_guard lock(product.arrivals.mutex);
  return {percentile(product.arrivals.ages_us, 0.99),
          static_cast<double>(product.arrivals.skipped)};
}

/// A bare gRPC server for as long as it lives.
struct Bare {
  BareServer service{};
  std::string address{};
  std::unique_ptr<grpc::Server> server{};

  Bare() {
    int port = 0;
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(&service);
    server = builder.BuildAndStart();
    if (server == nullptr) throw std::runtime_error("the bare gRPC server does not start");
    address = "127.0.0.1:" + std::to_string(port);
  }
  ~Bare() { server->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(1)); }
};

void print_tick_to_callback(const std::string& device, Product& product, Bare& bare) {
  std::vector<double> found, written;
  bench::print(bench::compare(
      "tick -> client callback one way p50: " + device, "bare gRPC stream", "us",
      [&] {
        const OneWay way = product_block(product, product.address());
        found.push_back(way.found_us);
        written.push_back(way.written_us);
        return way.down_us;
      },
      [&] { return bare_block(bare.service, bare.address).down_us; }, 1.3, 20));
  std::printf(
      "# stages: %.1f us after the begin of a tick its record is found, %.1f its state is "
      "written to gRPC (medians of p50)\n",
      percentile(found, 0.5), percentile(written, 0.5));
}

/// A state is stamped at the begin of its tick. A board's newest sample only has to be fetched
/// there; a simulated device computes its own first, which is no part of the way to the client.
void with_a_sample_that_lies_ready(Bare& bare) {
  constexpr double kEffort = 40.0;        // N: more than the scene's force limit
  constexpr double kBent = 30 * kDegree;  // both joints, the scene's target
  auto device = std::make_unique<test::ScriptedDevice>(kEffort);
  const auto finger = core::make_finger_exoskeleton({});
  if (finger->inverse(core::VecX::Constant(2, kBent), device->q) != core::InverseStatus::kExact) {
    throw std::runtime_error("the finger's pose is out of reach");
  }
  Product product({"127.0.0.1:0"}, {}, std::move(device));
  print_tick_to_callback("sample lies ready", product, bare);
}

void with_the_simulated_finger(Bare& bare) {
  Product product;
  bench::print(bench::compare(
      "publish -> mailbox one way p50", "bare gRPC stream", "us",
      [&] { return product_block(product, product.address()).up_us; },
      [&] { return bare_block(bare.service, bare.address).up_us; }, 1.3, 20));
  print_tick_to_callback("simulated finger", product, bare);
  double with = 0.0, without = 0.0;
  bench::print(bench::compare(
      "proxy age p99 beside 16 watchers at 1 kHz", "no watchers", "us",
      [&] {
        const Ages ages = ages_block(product, 16);
        with += ages.skipped;
        return ages.p99_us;
      },
      [&] {
        const Ages ages = ages_block(product, 0);
        without += ages.skipped;
        return ages.p99_us;
      },
      1.2, 20));
  std::printf("# skipped ticks: %.0f in 21 blocks with 16 watchers, %.0f in 41 without\n", with,
              without);
}

}  // namespace

int main() {
  spdlog::set_level(spdlog::level::warn);  // sessions that come and go
  bench::keep_processors_awake();
  bench::print_header();
  Bare bare;
  with_a_sample_that_lies_ready(bare);
  with_the_simulated_finger(bare);
  return 0;
}
