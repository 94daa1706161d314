/// haptic-bench-wire: one way from publish() to the mailbox and from the tick to the client's callback, against a
/// bare gRPC stream of the same messages on the same host; and the controller's proxy age beside 16 watchers at
/// 1 kHz. All clocks are this host's one steady clock.
#include <grpcpp/grpcpp.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <thread>
#include <vector>

#include "haptic/client/client.hpp"
#include "haptic/v1/haptic_service.grpc.pb.h"
#include "server/rpc/rpc_server.hpp"
#include "server/rt/loop.hpp"
#include "server/scene/scene.hpp"
#include "server/session/device_sessions.hpp"
#include "tests/bench/paired.hpp"

namespace {

using namespace haptic;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr int kSamples = 150;  // per block
constexpr milliseconds kEvery{4};

double percentile(std::vector<double> values, double p) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(p * static_cast<double>(values.size())))];
}
std::int64_t now_ns() {
  return Clock::now().time_since_epoch().count();
}

/// Arrival of each sample at the mailbox, and its age in every tick.
class Arrivals final : public server::RecordListener {
 public:
  void on_record(const core::TickRecord& record) override {
    const std::lock_guard lock(mutex);
    const core::ProxySnapshot& proxy = record.input.proxy;
    if (proxy.seq != last_) born.emplace_back(proxy.seq, proxy.born.time_since_epoch().count());
    last_ = proxy.seq;
    ages_us.push_back(core::seconds(record.proxy_age) * 1e6);
    skipped += record.input.loop.skipped;
  }
  std::mutex mutex;
  std::vector<std::pair<std::uint64_t, std::int64_t>> born{};
  std::vector<double> ages_us{};
  std::uint64_t skipped{0};

 private:
  std::uint64_t last_{0};
};

/// The server of hapticd, in this process, with our listener at its telemetry.
class Product {
 public:
  Product()
      : scene_(server::load_scene(HAPTIC_SOURCE_DIR "/server/scenes/finger_constant.textproto")),
        unit_(make_unit(scene_)),
        telemetry_({unit_.get()}),
        sessions_(*unit_, telemetry_, 0, {}),
        rpc_({{"127.0.0.1:0"}}, {&sessions_}, telemetry_, [] { return server::ServerFacts{}; }),
        loop_(server::RealtimeRequest{}, milliseconds(1)) {
    telemetry_.allow_watching(loop_.grant().facts.sched_fifo &&
                              std::thread::hardware_concurrency() > 1);
    telemetry_.add(0, &arrivals);
    telemetry_.start();
    rpc_.start();
    loop_.begin({unit_.get()}, telemetry_);
  }
  ~Product() {
    sessions_.begin_closing();
    loop_.finish(std::chrono::seconds(1));
    rpc_.shutdown(std::chrono::seconds(1));
    telemetry_.stop();
  }
  [[nodiscard]] std::string address() const { return rpc_.bound_addresses().front(); }

  Arrivals arrivals;

 private:
  static std::unique_ptr<server::DeviceUnit> make_unit(const server::Scene& scene) {
    const server::DeviceScene& device = scene.devices.front();
    auto opened = hw::open_device(device.source, device.kinematics);
    core::PipelineConfig config;
    config.kinematics = device.kinematics;
    config.device = opened->info().limits;
    config.scene = device.settings;
    config.late_bucket_full = 1'000'000;
    config.loop_late_fault = std::chrono::seconds(5);
    return std::make_unique<server::DeviceUnit>(device.name, std::move(opened), config);
  }
  server::Scene scene_;
  std::unique_ptr<server::DeviceUnit> unit_;
  server::Telemetry telemetry_;
  server::DeviceSessions sessions_;
  server::RpcServer rpc_;
  server::Loop loop_;
};

/// The peer: the same messages over the plainest stream gRPC offers; stamps arrivals.
class BareServer final : public v1::HapticService::CallbackService {
 public:
  grpc::ServerBidiReactor<v1::SessionRequest, v1::SessionResponse>* Session(
      grpc::CallbackServerContext*) override {
    return new Reactor(*this);
  }
  std::mutex mutex;
  std::vector<double> up_us{};

 private:
  class Reactor final : public grpc::ServerBidiReactor<v1::SessionRequest, v1::SessionResponse> {
   public:
    explicit Reactor(BareServer& server) : server_(server) {
      StartRead(&in_);
      writer_ = std::thread([this] {
        auto next = Clock::now();
        while (!over_) {
          next += milliseconds(1);
          std::this_thread::sleep_until(next);
          if (writing_.exchange(true)) continue;
          v1::DeviceState& state = *out_.mutable_state();
          fill(state);
          state.set_server_time_ns(now_ns());
          StartWrite(&out_);
        }
        while (writing_) std::this_thread::sleep_for(milliseconds(1));
        Finish(grpc::Status::OK);
      });
    }
    void OnReadDone(bool ok) override {
      if (!ok) {
        over_ = true;
        return;
      }
      {
        const std::lock_guard lock(server_.mutex);
        server_.up_us.push_back(static_cast<double>(now_ns() - in_.proxy().source_time_ns()) *
                                1e-3);
      }
      StartRead(&in_);
    }
    void OnWriteDone(bool) override { writing_ = false; }
    void OnDone() override {
      writer_.join();
      delete this;
    }
    static void fill(v1::DeviceState& state) {  // as large as the finger's
      state.Clear();
      state.set_seq(1'000'000);
      for (int i = 0; i < 2; ++i) {
        state.add_q(0.01 + i);
        state.add_x_probe(0.5);
        state.add_x(0.4);
        state.add_q_star(0.02);
      }
      state.add_q_dot(0.1);
      state.add_tau_a(1.5);
      state.add_tau_elastic(1.4);
      state.add_stiffness_in_effect(1500.0);
      state.set_proxy_seq_used(1000);
      state.set_proxy_age_us(3000);
      state.set_gain(1.0);
    }

   private:
    BareServer& server_;
    v1::SessionRequest in_;
    v1::SessionResponse out_;
    std::atomic<bool> writing_{false}, over_{false};
    std::thread writer_;
  };
};

class BareClient final : public grpc::ClientBidiReactor<v1::SessionRequest, v1::SessionResponse> {
 public:
  explicit BareClient(const std::string& address)
      : stub_(v1::HapticService::NewStub(
            grpc::CreateChannel(address, grpc::InsecureChannelCredentials()))) {
    stub_->async()->Session(&context_, this);
    AddHold();
    StartRead(&in_);
    StartCall();
  }
  ~BareClient() override {
    context_.TryCancel();
    RemoveHold();
    std::unique_lock lock(mutex);
    done_cv_.wait(lock, [this] { return done_; });
  }
  void send(std::uint64_t seq) {
    if (writing_.exchange(true)) return;
    v1::ProxySample& sample = *out_.mutable_proxy();
    sample.set_seq(seq);
    sample.set_mode(v1::PROXY_MODE_HELD);
    sample.clear_position();
    sample.add_position(0.4);
    sample.add_position(0.5);
    sample.set_source_time_ns(now_ns());
    StartWrite(&out_);
  }
  std::mutex mutex;
  std::vector<double> down_us{};

 private:
  void OnReadDone(bool ok) override {
    if (!ok) return;
    {
      const std::lock_guard lock(mutex);
      down_us.push_back(static_cast<double>(now_ns() - in_.state().server_time_ns()) * 1e-3);
    }
    StartRead(&in_);
  }
  void OnWriteDone(bool) override { writing_ = false; }
  void OnDone(const grpc::Status&) override {
    const std::lock_guard lock(mutex);
    done_ = true;
    done_cv_.notify_all();
  }
  std::unique_ptr<v1::HapticService::Stub> stub_;
  grpc::ClientContext context_;
  v1::SessionRequest out_;
  v1::SessionResponse in_;
  std::atomic<bool> writing_{false};
  bool done_{false};
  std::condition_variable done_cv_;
};

struct OneWay {
  double up_us{0.0}, down_us{0.0};  ///< p50
};

OneWay product_block(Product& product) {
  std::mutex mutex;
  std::vector<double> down;
  client::Connection connection(product.address());
  client::SessionOptions options;
  options.client_name = "bench";
  options.nominal_rate_hz = 250;
  options.on_state = [&](const client::DeviceState& state) {
    const std::lock_guard lock(mutex);
    down.push_back(static_cast<double>(now_ns() - state.server_time_ns) * 1e-3);
  };
  std::vector<std::int64_t> published;
  {
    const auto session = connection.open(options);
    {
      const std::lock_guard lock(product.arrivals.mutex);
      product.arrivals.born.clear();
    }
    auto next = Clock::now();
    for (int i = 0; i < kSamples; ++i) {
      next += kEvery;
      std::this_thread::sleep_until(next);
      published.push_back(now_ns());
      session->publish(client::Proxy::held({0.4, 0.5}));
    }
    std::this_thread::sleep_for(milliseconds(20));
  }
  std::vector<double> up;
  const std::lock_guard lock(product.arrivals.mutex);
  for (const auto& [seq, born] : product.arrivals.born) {
    if (seq == 0 || seq > published.size()) continue;
    up.push_back(static_cast<double>(born - published[seq - 1]) * 1e-3);
  }
  return {percentile(up, 0.5), percentile(down, 0.5)};
}

OneWay bare_block(BareServer& service, const std::string& address) {
  {
    const std::lock_guard lock(service.mutex);
    service.up_us.clear();
  }
  std::vector<double> down;
  {
    BareClient client(address);
    auto next = Clock::now();
    for (int i = 0; i < kSamples; ++i) {
      next += kEvery;
      std::this_thread::sleep_until(next);
      client.send(static_cast<std::uint64_t>(i + 1));
    }
    std::this_thread::sleep_for(milliseconds(20));
    const std::lock_guard lock(client.mutex);
    down = client.down_us;
  }
  const std::lock_guard lock(service.mutex);
  return {percentile(service.up_us, 0.5), percentile(down, 0.5)};
}

struct Ages {
  double p99_us{0.0};
  double skipped{0.0};
};

/// The controller's proxy age at use over 1 s at 500 Hz, with `watchers` at 1 kHz beside it.
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
  auto next = Clock::now();
  for (int i = 0; i < 600; ++i) {
    next += milliseconds(2);
    std::this_thread::sleep_until(next);
    session->publish(client::Proxy::held({0.4, 0.5}));
    if (i == 100) {
      const std::lock_guard lock(product.arrivals.mutex);
      product.arrivals.ages_us.clear();
      product.arrivals.skipped = 0;
    }
  }
  const std::lock_guard lock(product.arrivals.mutex);
  return {percentile(product.arrivals.ages_us, 0.99),
          static_cast<double>(product.arrivals.skipped)};
}

}  // namespace

int main() {
  spdlog::set_level(spdlog::level::warn);  // sessions that come and go
  bench::print_header();
  Product product;
  BareServer service;
  int port = 0;
  grpc::ServerBuilder builder;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterService(&service);
  const auto peer = builder.BuildAndStart();
  const std::string peer_address = "127.0.0.1:" + std::to_string(port);

  bench::print(bench::compare(
      "publish -> mailbox one way p50", "bare gRPC stream", "us",
      [&] { return product_block(product).up_us; },
      [&] { return bare_block(service, peer_address).up_us; }, 1.3, 20));
  bench::print(bench::compare(
      "tick -> client callback one way p50", "bare gRPC stream", "us",
      [&] { return product_block(product).down_us; },
      [&] { return bare_block(service, peer_address).down_us; }, 1.3, 20));
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
  peer->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(1));
  return 0;
}
