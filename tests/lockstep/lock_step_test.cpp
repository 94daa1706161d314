/// In lock-step - a clock of the test's own, tick k runs after the samples of its millisecond were accepted,
/// arrivals stamped by that clock - the carrier makes no difference: the same run in-process, over gRPC on
/// TCP, over gRPC on a UNIX socket and over UDP gives the same force, bit for bit.

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <bit>
#include <map>
#include <mutex>
#include <thread>

#include "haptic/client/client.hpp"
#include "server/rpc/rpc_server.hpp"
#include "server/scene/scene.hpp"
#include "tests/support/link/impaired_link.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

constexpr core::Duration kTick = 1ms;
constexpr int kTicks = 4000;
constexpr int kFirstSample = 20, kSampleEvery = 10;  // ticks
constexpr int kEngageAt = 500;
constexpr double kWall = 0.35;  // rad, where the soft grasp's finger is stopped

/// The shipped server around the shipped soft grasp, without a loop and without a clock.
class Server {
 public:
  Server()
      : scene_(server::load_scene(HAPTIC_SOURCE_DIR "/server/scenes/finger_soft_grasp.textproto")),
        unit_(make_unit(scene_.devices.front())),
        telemetry_({unit_.get()}),
        sessions_(*unit_, telemetry_, 0, {}) {
    for (int i = 0; i < 3; ++i) tick();
  }

  /// Serves at `address`, and by UDP.
  void serve(const std::string& address) {
    server::RpcConfig config;
    config.listen = {address};
    config.udp_listen = "127.0.0.1:0";
    config.clock = [this](core::Duration) { return now(); };
    config.age_by_source_time = false;
    rpc_ = std::make_unique<server::RpcServer>(config,
                                               std::vector<server::DeviceSessions*>{&sessions_},
                                               telemetry_, [] { return server::ServerFacts{}; });
    rpc_->start();
  }
  [[nodiscard]] std::string address() const { return rpc_->bound_addresses().front(); }

  core::TickRecord tick() {
    now_ += kTick.count();
    unit_->tick(now(), kTick, {});
    telemetry_.drain();
    return sessions_.newest();
  }
  /// A request to the loop was posted; it stays posted.
  void wait_for_request() {
    // This thread is the mailbox's reader: what it takes it puts back before anybody else may post.
    while (!unit_->commands.take()) std::this_thread::yield();
    unit_->commands.publish(core::CommandSnapshot(unit_->commands.value()));
  }
  [[nodiscard]] std::uint64_t accepted() {
    const auto counters = sessions_.ingress().counters();
    return counters.accepted + counters.backlog;
  }
  [[nodiscard]] core::TimePoint now() const { return core::TimePoint(core::Duration(now_)); }
  [[nodiscard]] server::DeviceSessions& sessions() { return sessions_; }

 private:
  static std::unique_ptr<server::DeviceUnit> make_unit(const server::DeviceScene& scene) {
    auto device = hw::open_device(scene.source, scene.kinematics);
    auto config = server::pipeline_config(scene, device->info().limits);
    return std::make_unique<server::DeviceUnit>("finger", std::move(device), std::move(config));
  }

  std::atomic<std::int64_t> now_{core::Duration(1h).count()};
  server::Scene scene_;
  std::unique_ptr<server::DeviceUnit> unit_;
  server::Telemetry telemetry_;
  server::DeviceSessions sessions_;
  std::unique_ptr<server::RpcServer> rpc_{};
};

/// What carries samples to the server.
class Way {
 public:
  virtual ~Way() = default;
  /// Returns when the sample was accepted.
  virtual void publish(Server& server, const std::vector<double>& x) = 0;
  /// Returns when the request waits for the next tick.
  virtual void ask_for_force(Server& server) = 0;
  /// After that tick.
  virtual void expect_force() = 0;
};

class InProcess final : public Way {
 public:
  explicit InProcess(Server& server) {
    server::LeaseRequest request;
    request.session_id = "s1";
    request.client_name = "in process";
    request.nominal_rate_hz = 1000.0 / kSampleEvery;
    server.sessions().open_controller(request, server.now(),
                                      [this](const server::Outcome<server::Lease>& outcome) {
                                        if (outcome) epoch_ = outcome.value->epoch;
                                      });
    EXPECT_GT(epoch_, 0U);
  }
  void publish(Server& server, const std::vector<double>& x) override {
    server::ProxyCandidate candidate;
    candidate.epoch = epoch_;
    candidate.seq = ++seq_;
    candidate.mode = core::ProxyMode::kHeld;
    candidate.position = x.data();
    candidate.position_size = static_cast<int>(x.size());
    static_cast<void>(server.sessions().ingress().accept(candidate, server.now()));
  }
  void ask_for_force(Server& server) override {
    server.sessions().engage("s1", [this](const server::Outcome<server::Done>& outcome) {
      granted_ = static_cast<bool>(outcome);
    });
  }
  void expect_force() override { EXPECT_TRUE(granted_); }

 private:
  std::uint32_t epoch_{0};
  std::uint64_t seq_{0};
  bool granted_{false};
};

class ByClient final : public Way {
 public:
  ByClient(Server& server, client::Carriers carriers) : connection_(server.address()) {
    client::SessionOptions options;
    options.nominal_rate_hz = 1000.0 / kSampleEvery;
    options.carriers = carriers;
    options.on_state = [this](const client::DeviceState& state) {
      const std::lock_guard lock(mutex_);
      if (!state.tau_a.empty()) heard_[state.seq] = state.tau_a[0];
    };
    session_ = connection_.open(options);
    if (carriers != client::Carriers::kUdpOnly) return;
    while (!session_->udp_link()->in_use) std::this_thread::sleep_for(1ms);
  }
  void publish(Server& server, const std::vector<double>& x) override {
    const std::uint64_t before = server.accepted();
    while (server.accepted() == before) {
      session_->publish(client::Proxy::held(x));
      // A datagram may be lost, and a path fall silent on a busy machine: then once more.
      const auto patience = std::chrono::steady_clock::now() + 2s;
      while (server.accepted() == before && std::chrono::steady_clock::now() < patience) {
        std::this_thread::yield();
      }
    }
    ASSERT_EQ(server.accepted(), before + 1);
  }
  void ask_for_force(Server& server) override {
    asking_ = std::thread([this] { session_->engage(); });
    server.wait_for_request();
  }
  void expect_force() override { asking_.join(); }

  /// Force by tick, as the states that came down tell it.
  [[nodiscard]] std::map<std::uint64_t, double> heard() {
    const std::lock_guard lock(mutex_);
    return heard_;
  }

 private:
  std::mutex mutex_;
  std::map<std::uint64_t, double> heard_{};
  client::Connection connection_;
  std::unique_ptr<client::Session> session_{};
  std::thread asking_{};
};

struct Trace {
  std::vector<std::uint64_t> tau{}, elastic{};  ///< bits
  std::map<std::uint64_t, double> by_tick{};
  double peak{0.0};
  bool held_over{false};  ///< the proxy grew old at times
};

/// The wall holds the finger; what the client sends meets a link of jitter and loss before it meets the
/// carrier.
Trace run(Server& server, Way& way) {
  WayRules trouble;
  trouble.delay = 8ms;
  trouble.jitter_sigma = 8ms;
  trouble.loss = 0.1;
  ImpairedLink link(trouble, 42, Carrier::kUdp);
  std::map<std::uint8_t, std::vector<double>> on_the_way;
  std::uint8_t number = 0;
  Trace trace;
  core::TickRecord record = server.tick();
  for (int k = 0; k < kTicks; ++k) {
    const LinkTime time = k * kTick;
    if (k >= kFirstSample && k % kSampleEvery == 0) {
      std::vector<double> x(record.x_probe.data(), record.x_probe.data() + record.x_probe.size());
      x[0] = std::min(x[0], kWall);
      on_the_way[++number] = x;
      link.send({number}, time);
    }
    while (auto arrived = link.receive(time)) {
      way.publish(server, on_the_way.at(arrived->second.front()));
    }
    if (k == kEngageAt) way.ask_for_force(server);
    record = server.tick();
    if (k == kEngageAt) way.expect_force();
    trace.tau.push_back(std::bit_cast<std::uint64_t>(record.tau_a[0]));
    trace.elastic.push_back(std::bit_cast<std::uint64_t>(record.tau_elastic[0]));
    trace.by_tick[record.tick] = record.tau_a[0];
    trace.peak = std::max(trace.peak, std::abs(record.tau_a[0]));
    trace.held_over = trace.held_over || record.staleness == core::Staleness::kHold;
  }
  return trace;
}

const Trace& in_process() {
  static const Trace kTrace = [] {
    Server server;
    InProcess way(server);
    return run(server, way);
  }();
  return kTrace;
}

/// States are conflated where a stream is slow; those that came say what the loop did.
void expect_same(const Trace& trace, ByClient& way) {
  EXPECT_EQ(trace.tau, in_process().tau);
  EXPECT_EQ(trace.elastic, in_process().elastic);
  const auto heard = way.heard();
  EXPECT_GT(heard.size(), 100U);
  for (const auto& [tick, tau] : heard) {
    const auto entry = trace.by_tick.find(tick);
    if (entry != trace.by_tick.end()) {
      ASSERT_EQ(tau, entry->second) << tick;
    }
  }
}

TEST(LockStep, TheRunHasForceAndTrouble) {
  EXPECT_GT(in_process().peak, 0.5);
  EXPECT_TRUE(in_process().held_over);
}

TEST(LockStep, InProcessTwiceIsTheSame) {
  Server server;
  InProcess way(server);
  EXPECT_EQ(run(server, way).tau, in_process().tau);
}

TEST(LockStep, GrpcOverTcpIsTheSame) {
  Server server;
  server.serve("127.0.0.1:0");
  ByClient way(server, client::Carriers::kGrpcOnly);
  expect_same(run(server, way), way);
}

TEST(LockStep, GrpcOverAUnixSocketIsTheSame) {
  Server server;
  server.serve("unix:/tmp/haptic-lockstep-" + std::to_string(getpid()));
  ByClient way(server, client::Carriers::kGrpcOnly);
  expect_same(run(server, way), way);
}

TEST(LockStep, UdpIsTheSame) {
  Server server;
  server.serve("127.0.0.1:0");
  ByClient way(server, client::Carriers::kUdpOnly);
  expect_same(run(server, way), way);
  EXPECT_EQ(server.sessions().ingress().carrier(), server::Carrier::kUdp);
}

}  // namespace
}  // namespace haptic::test
