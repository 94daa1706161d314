/// In lock-step - a clock of the test's own, tick k runs after the samples of its millisecond were
/// accepted, arrivals stamped by that clock - the carrier makes no difference: the same run
/// in-process, over gRPC on TCP, over gRPC on a UNIX socket, over UDP, by the C library, and from
/// JavaScript and C# over a WebSocket gives the same force, bit for bit.

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <bit>
#include <map>
#include <sstream>
#include <thread>

#include "server/owner/scene/scene.hpp"
#include "tests/server/owner/loop/record_keeper.hpp"
#include "tests/server/support/test_client.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/link/impaired_link.hpp"
#include "tests/support/temporary_file.hpp"
#include "tests/support/udp_end.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

constexpr core::Duration kTick = 1ms;
constexpr int kTicks = 4000;
constexpr int kFirstSample = 20, kSampleEvery = 10;  // ticks; 100 Hz, as open_message() says
constexpr int kEngageAt = 500;
constexpr double kWall = 0.35;  // rad, where the soft grasp's finger is stopped

/// The shipped server around the shipped soft grasp, without a loop and without a clock.
class Server {
 public:
  Server()
      : scene_(server::load_scene(HAPTIC_SOURCE_DIR "/server/scenes/finger_soft_grasp.textproto")),
        unit_(make_unit(scene_.devices.front())),
        telemetry_({unit_.get()}),
        owner_(telemetry_) {
    owner_.add(*unit_, {});
    telemetry_.add(0, &records_);
    front_ = HandFront::of(owner_);
    for (int i = 0; i < 3; ++i) tick();
  }

  /// Serves at `address`, by UDP, and to whom shows the token in the file.
  void serve(const std::string& address, const std::string& token_file = {}) {
    server::ServerScene scene{.listen = {address}, .udp_listen = "127.0.0.1:0"};
    scene.web = server::WebConfig{.listen = {web_, "127.0.0.1:0"}};
    if (!token_file.empty()) {
      scene.web->tokens = {{"test", token_file, {true, server::Priority::kPrimary}}};
    }
    hand_over_ =
        std::make_unique<server::HandOver>(server::front_config(scene, false), scene, "/no/page");
    server::ServiceLimits limits{.age_by_source_time = false};
    limits.clock = [this](core::Duration) { return now(); };
    rpc_ = std::make_unique<server::FrontServer>(
        hand_over_->start(), owner_,
        server::FrontSources{[] { return server::ServerFacts{}; }, {}, {}}, limits);
    rpc_->start();
  }
  [[nodiscard]] std::string address() const { return hand_over_->addresses().front(); }
  [[nodiscard]] const std::string& web_socket() const { return web_; }
  [[nodiscard]] std::string web_address() const {
    return "http://" + hand_over_->addresses().at(2);
  }

  core::TickRecord tick() {
    now_ += kTick.count();
    unit_->tick(now(), kTick, {});
    records_.records.clear();
    telemetry_.drain();
    return records_.records.back();
  }
  /// A request to the loop was posted; it stays posted.
  void wait_for_request() {
    // This thread is the mailbox's reader: what it takes it puts back before anybody else may post.
    while (!unit_->commands.take()) std::this_thread::yield();
    unit_->commands.publish(core::CommandSnapshot(unit_->commands.value()));
  }
  [[nodiscard]] std::uint64_t accepted() {
    const auto counters = owner_.status(0).samples;
    return counters[server::IngressVerdict::kAccepted] + counters[server::IngressVerdict::kBacklog];
  }
  [[nodiscard]] core::TimePoint now() const { return core::TimePoint(core::Duration(now_)); }
  [[nodiscard]] server::Owner& owner() { return owner_; }
  [[nodiscard]] HandFront& front() { return *front_; }

 private:
  static std::unique_ptr<server::DeviceUnit> make_unit(const server::DeviceScene& scene) {
    auto device = scene.source->open(scene.pipeline.kinematics, {});
    auto config = server::pipeline_config(scene, device->info().limits);
    return std::make_unique<server::DeviceUnit>("finger", std::move(device), std::move(config));
  }

  std::atomic<std::int64_t> now_{core::Duration(1h).count()};
  server::Scene scene_;
  std::unique_ptr<server::DeviceUnit> unit_;
  RecordKeeper records_{};
  server::Telemetry telemetry_;
  server::Owner owner_;
  std::shared_ptr<HandFront> front_{};
  const std::string web_{"unix:/tmp/haptic-lockstep-web-" + std::to_string(getpid())};
  std::unique_ptr<server::HandOver> hand_over_{};
  std::unique_ptr<server::FrontServer> rpc_{};
};

/// Carrier of samples to the server.
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
    server::LeaseRequest request{
        .session_id = "s1", .client_name = "in process", .nominal_rate_hz = 1000.0 / kSampleEvery};
    server.front().open_controller(request, server.now(),
                                   [this](const Outcome<server::Lease>& outcome) {
                                     if (outcome) epoch_ = outcome.value->epoch;
                                   });
    EXPECT_GT(epoch_, 0U);
  }
  void publish(Server& server, const std::vector<double>& x) override {
    server::ProxySample sample{.epoch = epoch_,
                               .seq = ++seq_,
                               .arrival = server.now(),
                               .mode = seq_ == 1 ? core::ProxyMode::kFree : core::ProxyMode::kHeld,
                               .position = {x.data(), x.size()}};
    static_cast<void>(server.owner().accept(sample));
  }
  void ask_for_force(Server& server) override {
    server.front().engage(
        "s1", [this](const Outcome<Done>& outcome) { granted_ = static_cast<bool>(outcome); });
  }
  void expect_force() override { EXPECT_TRUE(granted_); }

 private:
  std::uint32_t epoch_{0};
  std::uint64_t seq_{0};
  bool granted_{false};
};

/// A client on the bare stubs, and on one end of a UDP path where it shall use that. Its samples
/// name no source time: its clock is not the test's.
class ByWire final : public Way {
 public:
  ByWire(Server& server, bool by_udp)
      : session_(grpc::CreateChannel(server.address(), grpc::InsecureChannelCredentials()),
                 opening(by_udp)) {
    EXPECT_TRUE(session_.wait_opened());
    if (!by_udp) return;
    if (!session_.opened().has_udp()) throw std::runtime_error(session_.opened().udp_refused());
    const v1::UdpPath offer = session_.opened().udp();
    udp_ = std::make_unique<UdpEnd>(wire::End::kClient, keys_of(offer),
                                    static_cast<std::uint16_t>(offer.port()));
    EXPECT_TRUE(eventually([this] { return udp_->in_use(); }));
  }

  void publish(Server& server, const std::vector<double>& x) override {
    const std::uint64_t before = server.accepted();
    while (server.accepted() == before) {
      v1::SessionRequest message;
      message.mutable_proxy()->set_seq(++seq_);
      message.mutable_proxy()->set_mode(before == 0 ? v1::PROXY_MODE_FREE : v1::PROXY_MODE_HELD);
      message.mutable_proxy()->mutable_position()->Add(x.begin(), x.end());
      if (udp_) {
        static_cast<void>(udp_->send(message.proxy().SerializeAsString()));
      } else {
        ASSERT_TRUE(session_.send(message));
      }
      // A datagram may be lost, and a path fall silent on a busy machine: then once more.
      const auto patience = std::chrono::steady_clock::now() + 2s;
      while (server.accepted() == before && std::chrono::steady_clock::now() < patience) {
        std::this_thread::yield();
      }
    }
    ASSERT_EQ(server.accepted(), before + 1);
  }
  void ask_for_force(Server& server) override {
    asking_ = std::thread([this] { granted_ = session_.engage().ok(); });
    server.wait_for_request();
  }
  void expect_force() override {
    asking_.join();
    EXPECT_TRUE(granted_);
  }

  /// The newest state that came down, by either carrier.
  [[nodiscard]] v1::DeviceState heard() {
    v1::DeviceState newest = session_.state();
    for (const std::string& message : udp_ ? udp_->messages() : std::vector<std::string>{}) {
      v1::DeviceState state;
      if (state.ParseFromString(message) && state.seq() > newest.seq()) newest = state;
    }
    return newest;
  }

 private:
  static v1::SessionRequest opening(bool by_udp) {
    v1::SessionRequest message = open_message(v1::ROLE_CONTROLLER, "by wire");
    message.mutable_open()->set_udp_wanted(by_udp);
    return message;
  }
  static wire::PathKeys keys_of(const v1::UdpPath& udp) {
    wire::PathKeys keys{.path_id = udp.path_id()};
    std::copy_n(udp.up_key().begin(), wire::kKeySize, keys.up.key.begin());
    std::copy_n(udp.up_salt().begin(), wire::kSaltSize, keys.up.salt.begin());
    std::copy_n(udp.down_key().begin(), wire::kKeySize, keys.down.key.begin());
    std::copy_n(udp.down_salt().begin(), wire::kSaltSize, keys.down.salt.begin());
    return keys;
  }

  TestSession session_;
  std::unique_ptr<UdpEnd> udp_{};
  std::uint64_t seq_{0};
  std::atomic<bool> granted_{false};
  std::thread asking_{};
};

/// A client in a process of its own that does what it is told line by line:
/// tests/client/c/lock_step_client.c, and the same in JavaScript and C#. libhaptic could not be in
/// this one, which has the protocol's messages already.
class ByProgram final : public Way {
 public:
  explicit ByProgram(std::vector<std::string> command) : client_(std::move(command)) {
    EXPECT_TRUE(answered(client_.read_line()));
  }
  void publish(Server& server, const std::vector<double>& x) override {
    const std::uint64_t before = server.accepted();
    std::string line = before == 0 ? "free" : "held";
    for (std::size_t i = 0; before > 0 && i < x.size(); ++i) line += " " + bits(x[i]);
    client_.write_line(line);
    ASSERT_TRUE(answered(client_.read_line()));
    ASSERT_TRUE(eventually([&] { return server.accepted() > before; }));
    ASSERT_EQ(server.accepted(), before + 1);
  }
  void ask_for_force(Server& server) override {
    client_.write_line("engage");
    server.wait_for_request();
  }
  void expect_force() override { EXPECT_TRUE(answered(client_.read_line())); }

  /// `seq` and `tau_a` of the newest state that came.
  [[nodiscard]] std::pair<std::uint64_t, double> heard() {
    client_.write_line("state");
    std::istringstream answer(client_.read_line());
    std::uint64_t code = 0, seq = 0, tau_a = 0;
    answer >> code >> seq >> std::hex >> tau_a;
    return {seq, std::bit_cast<double>(tau_a)};
  }

 private:
  static testing::AssertionResult answered(const std::string& line) {
    if (line.rfind("0 ", 0) == 0) return testing::AssertionSuccess();
    return testing::AssertionFailure() << "the client says '" << line << "'";
  }
  static std::string bits(double value) {
    std::ostringstream text;
    text << std::hex << std::bit_cast<std::uint64_t>(value);
    return text.str();
  }

  ChildProcess client_;
};

struct Trace {
  std::vector<std::uint64_t> tau{};  ///< bits
  std::map<std::uint64_t, double> by_tick{};
  double peak{0.0};
  bool held_over{false};  ///< the proxy grew old at times
};

/// The wall holds the finger; what the client sends meets a link of jitter and loss before it meets
/// the carrier.
Trace run(Server& server, Way& way) {
  WayRules trouble{.delay = 8ms, .jitter_sigma = 8ms, .loss = 0.1};
  ImpairedLink link(trouble, 42, Carrier::kUdp);
  std::map<std::uint8_t, std::vector<double>> on_the_way;
  std::uint8_t number = 0;
  Trace trace;
  core::TickRecord record = server.tick();
  for (int k = 0; k < kTicks; ++k) {
    const LinkTime time = k * kTick;
    if (k >= kFirstSample && k % kSampleEvery == 0) {
      std::vector<double> x(record.anchor.x_probe.data(),
                            record.anchor.x_probe.data() + record.anchor.x_probe.size());
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
    trace.tau.push_back(std::bit_cast<std::uint64_t>(record.effort.tau_a[0]));
    trace.by_tick[record.beat.tick] = record.effort.tau_a[0];
    trace.peak = std::max(trace.peak, std::abs(record.effort.tau_a[0]));
    trace.held_over = trace.held_over || record.proxy.level == core::Staleness::kHold;
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

/// States are conflated; the newest that came says what the loop did at its tick.
void expect_same(const Trace& trace, ByWire& way) {
  EXPECT_EQ(trace.tau, in_process().tau);
  const v1::DeviceState state = way.heard();
  const auto entry = trace.by_tick.find(state.seq());
  ASSERT_NE(entry, trace.by_tick.end()) << state.seq();
  ASSERT_EQ(state.tau_a_size(), 1);
  EXPECT_EQ(state.tau_a(0), entry->second);
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

TEST(LockStep, GrpcIsTheSame) {
  for (const std::string& address :
       {std::string("127.0.0.1:0"), "unix:/tmp/haptic-lockstep-" + std::to_string(getpid())}) {
    SCOPED_TRACE(address);
    Server server;
    server.serve(address);
    ByWire way(server, false);
    expect_same(run(server, way), way);
  }
}

TEST(LockStep, UdpIsTheSame) {
  Server server;
  server.serve("127.0.0.1:0");
  ByWire way(server, true);
  expect_same(run(server, way), way);
  EXPECT_EQ(server.owner().status(0).carrier, server::Carrier::kUdp);
}

void expect_same(Server& server, ByProgram&& way) {
  const Trace trace = run(server, way);
  EXPECT_EQ(trace.tau, in_process().tau);
  const auto [seq, tau_a] = way.heard();
  ASSERT_EQ(trace.by_tick.count(seq), 1U) << seq;
  EXPECT_EQ(trace.by_tick.at(seq), tau_a);
}

TEST(LockStep, TheCLibraryIsTheSame) {
  Server server;
  server.serve("127.0.0.1:0");
  expect_same(server, ByProgram({HAPTIC_BINARY_DIR "/client/c/haptic_c_lock_step_client",
                                 server.address()}));
}

TEST(LockStep, JavaScriptIsTheSame) {
  const std::string node = HAPTIC_NODE;
  if (node.empty()) GTEST_SKIP() << "the JavaScript client is not built";
  for (const char* format : {"binary", "json"}) {
    SCOPED_TRACE(format);
    Server server;
    server.serve("127.0.0.1:0");
    expect_same(server, ByProgram({node, HAPTIC_SOURCE_DIR "/tests/client/js/lock_step_client.mjs",
                                   HAPTIC_BINARY_DIR "/client/js", server.web_socket(), format}));
  }
}

#ifdef HAPTIC_MONO
TEST(LockStep, CSharpIsTheSame) {
  const std::string token = "a-token-of-this-test";
  const TemporaryFile file(token, "token");
  std::filesystem::permissions(file.path(), std::filesystem::perms::owner_read);
  Server server;
  server.serve("127.0.0.1:0", file.path());
  expect_same(server, ByProgram({HAPTIC_MONO, HAPTIC_BINARY_DIR "/client/csharp/LockStepClient.exe",
                                 server.web_address(), token}));
}
#endif

}  // namespace
}  // namespace haptic::test
