/// haptic-bench-web: one way from a WebSocket's write to the mailbox, against a bare echo by Beast
/// of messages as large, on the same host. All times are of this host's steady clock. And how late
/// the loop of the shipped hapticd wakes while 16 viewers look on as the page does, at 60 Hz,
/// against none: from the record of its ticks, with a fresh hapticd for every block. Its loop has
/// the last core for itself, as server/README.md advises. Idle processors are kept awake, as
/// hapticd does while a device is controlled.
#include <spdlog/spdlog.h>

#include <atomic>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/bench/crossing_servers.hpp"
#include "tests/bench/paired.hpp"
#include "tests/bench/web_client.hpp"
#include "tests/relay/daemon.hpp"
#include "tests/relay/run_record.hpp"

namespace {

using namespace haptic;
using namespace haptic::bench;

/// When each of `kSamples` was written, ns.
std::vector<std::int64_t> write_samples(WebClient& client) {
  auto written = paced(kSamples, kEvery, [&](std::uint64_t i) { client.write(sample(i)); });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return written;
}

/// Echoes to one client at a time, and keeps when each message came.
class Bare {
 public:
  Bare() : thread_([this] { run(); }) {}
  ~Bare() {
    stopping_ = true;
    beast::error_code ignored;
    tcp::socket last(context_);
    static_cast<void>(last.connect(acceptor_.local_endpoint(), ignored));
    thread_.join();
  }
  [[nodiscard]] std::string address() const {
    return "127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port());
  }
  std::vector<At> came{};  ///< of the client that has gone

 private:
  void run() {
    while (true) {
      BareSocket socket(acceptor_.accept());
      if (stopping_) return;
      beast::get_lowest_layer(socket).set_option(tcp::no_delay(true));
      socket.set_option(websocket::stream_base::decorator([](websocket::response_type& head) {
        head.set(beast::http::field::sec_websocket_protocol, "haptic.v1.proto");
      }));
      beast::error_code error;
      socket.accept(error);
      socket.binary(true);
      came.clear();
      beast::flat_buffer buffer;
      while (!error) {
        buffer.clear();
        socket.read(buffer, error);
        came.emplace_back(came.size() + 1, now_ns());
        if (!error) socket.write(buffer.data(), error);
      }
    }
  }
  asio::io_context context_{};
  tcp::acceptor acceptor_{context_, {asio::ip::make_address("127.0.0.1"), 0}};
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

double product_block(Product& product) {
  std::vector<std::int64_t> written;
  {
    WebClient client(product.address(1));
    client.control(250.0);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    product.arrivals.restart();
    written = write_samples(client);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // the force is gone
  const std::lock_guard lock(product.arrivals.mutex);
  const std::vector<double> up = ways_us(product.arrivals.born, written);
  if (up.size() < kSamples / 2) throw std::runtime_error("too few samples arrived");
  return percentile(up, 0.5);
}

double bare_block(Bare& bare) {
  std::vector<std::int64_t> written;
  {
    WebClient client(bare.address());
    written = write_samples(client);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return percentile(ways_us(bare.came, written), 0.5);
}

constexpr int kViewers = 16;
constexpr double kViewerHz = 60.0;
constexpr int kViewed = 1500;  // ticks of 1 ms

/// p99 of the loop's lateness in us, while so many look on.
double viewed_block(int viewers, std::optional<int> loop_cpu) {
  std::vector<std::string> pinned;
  if (loop_cpu) pinned = {"--set", "loop.cpu=" + std::to_string(*loop_cpu)};
  test::Daemon daemon(pinned);
  const std::string address = "127.0.0.1:" + std::to_string(daemon.web_port());
  std::vector<std::unique_ptr<WebClient>> clients;
  for (int i = 0; i < viewers; ++i) {
    clients.push_back(std::make_unique<WebClient>(address, test::Daemon::kToken));
    clients.back()->observe(kViewerHz);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(kViewed + 500));
  if (daemon.stop() != 0) throw std::runtime_error("hapticd failed");
  for (const auto& client : clients) {
    if (static_cast<double>(client->received()) < kViewerHz * kViewed / 2000) {
      throw std::runtime_error("a viewer saw less than half of the states");
    }
  }
  std::vector<double> late_us;
  for (const test::RecordedTick& tick : test::read_record(daemon.record())) {
    if (tick.state == "IDLE") late_us.push_back(1e6 * tick.lateness);
  }
  if (late_us.size() < kViewed) throw std::runtime_error("too few ticks");
  return percentile({late_us.end() - kViewed, late_us.end()}, 0.99);
}

/// While it lives, the calling thread and those that it makes run on one core.
class OnOneCore {
 public:
  OnOneCore() {
    sched_getaffinity(0, sizeof before_, &before_);
    cpu_set_t only;
    CPU_ZERO(&only);
    CPU_SET(static_cast<std::size_t>(sched_getcpu()), &only);
    sched_setaffinity(0, sizeof only, &only);
  }
  ~OnOneCore() { sched_setaffinity(0, sizeof before_, &before_); }
  OnOneCore(const OnOneCore&) = delete;
  OnOneCore& operator=(const OnOneCore&) = delete;

 private:
  cpu_set_t before_{};
};

}  // namespace

int main() {
  spdlog::set_level(spdlog::level::warn);  // sessions that come and go
  bench::keep_processors_awake();
  const std::optional<int> loop_cpu = bench::leave_a_core_to_the_loop();
  bench::print_header();
  {
    // Else the scheduler runs writer and reader on one core in some blocks and on two in others,
    // which makes more of a difference than what is measured.
    const OnOneCore all;
    const BenchWeb web;
    Product product({"127.0.0.1:0"}, {}, nullptr, web.config());
    Bare bare;
    bench::print(bench::compare(
        "WebSocket write -> mailbox one way p50", "bare echo by Beast", "us",
        [&] { return product_block(product); }, [&] { return bare_block(bare); }, 1.3, 20));
  }
  bench::print(bench::compare(
      "loop wake lateness p99 with 16 viewers at 60 Hz", "no viewers", "us",
      [&] { return viewed_block(kViewers, loop_cpu); }, [&] { return viewed_block(0, loop_cpu); },
      1.2, 20));
  return 0;
}
