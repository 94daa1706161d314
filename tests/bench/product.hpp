#pragma once
/// The server of hapticd in a benchmark's own process, with a listener at its telemetry. All
/// clocks are this host's one steady clock.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "hw/device.hpp"
#include "hw/device_config.hpp"
#include "server/front/server.hpp"
#include "server/owner/link/hand_over.hpp"
#include "server/owner/loop/loop.hpp"
#include "server/owner/rights/owner.hpp"
#include "server/owner/scene/scene.hpp"
#include "tests/server/support/port_of.hpp"
#include "tests/support/percentile.hpp"

namespace haptic::bench {

using test::percentile;

inline constexpr int kSamples = 150;  ///< per block of one-way times
inline constexpr std::chrono::milliseconds kEvery{4};

inline std::int64_t now_ns() {
  return std::chrono::steady_clock::now().time_since_epoch().count();
}

/// Keeps processors awake as hapticd does while a device is controlled, for the peer too.
inline void keep_processors_awake() {
  server::RealtimeHost& host = server::real_host();
  if (host.open_idle_latency() == 0) host.keep_awake(true);
}

/// A sample's number, and a time in ns.
using At = std::pair<std::uint64_t, std::int64_t>;

/// Calls act(1) to act(count), `every` apart. When each call began, ns.
template <typename Act>
std::vector<std::int64_t> paced(std::uint64_t count, std::chrono::milliseconds every,
                                const Act& act) {
  std::vector<std::int64_t> times;
  auto next = std::chrono::steady_clock::now();
  for (std::uint64_t i = 1; i <= count; ++i) {
    std::this_thread::sleep_until(next += every);
    times.push_back(now_ns());
    act(i);
  }
  return times;
}

/// us from when each sample was published, `published[number - 1]`, to when it was there.
inline std::vector<double> ways_us(const std::vector<At>& there,
                                   const std::vector<std::int64_t>& published) {
  std::vector<double> ways;
  for (const auto& [seq, at] : there) {
    if (seq == 0 || seq > published.size()) continue;
    ways.push_back(static_cast<double>(at - published[seq - 1]) * 1e-3);
  }
  return ways;
}

/// Arrival of each sample at the mailbox, its age in every tick, the stages of each state's way
/// out, and which sample each tick used.
class Arrivals final : public server::RecordListener {
 public:
  void on_record(const core::TickRecord& record) override {
    const std::lock_guard lock(mutex);
    found_us.push_back(since_tick_us(record));
    const core::ProxyInUse& proxy = record.proxy;
    const core::TimePoint now = record.input.now;
    if (proxy.seq != last_) {
      born.emplace_back(proxy.seq, (now - proxy.age).time_since_epoch().count());
    }
    last_ = proxy.seq;
    ages_us.push_back(core::seconds(proxy.age) * 1e6);
    if (proxy.mode != core::ProxyMode::kNone) {
      used.emplace_back(proxy.seq, now.time_since_epoch().count());
    }
    skipped += record.input.loop.skipped;
  }
  void on_newest(const core::TickRecord& record) override {  // the sessions' listener came before
    const std::lock_guard lock(mutex);
    written_us.push_back(since_tick_us(record));
  }
  /// Forgets what was seen so far.
  void restart() {
    const std::lock_guard lock(mutex);
    for (auto* times : {&found_us, &written_us, &ages_us}) times->clear();
    born.clear();
    used.clear();
    skipped = 0;
  }
  std::mutex mutex;
  /// After the begin of a tick: its record is found in the ring, its state is written to gRPC.
  std::vector<double> found_us{}, written_us{};
  std::vector<At> born{}, used{};  ///< with the time of arrival, of the tick
  std::vector<double> ages_us{};
  std::uint64_t skipped{0};

 private:
  static double since_tick_us(const core::TickRecord& record) {
    return static_cast<double>(now_ns() - record.input.now.time_since_epoch().count()) * 1e-3;
  }
  std::uint64_t last_{0};
};

/// The server of hapticd in this process; `arrivals` listens to its telemetry.
class Product {
 public:
  /// Serves at `listen`, UDP at `udp_listen` (empty: none) and `web`. `device`: null: the scene's
  /// simulated finger, whose physics is part of every tick.
  explicit Product(std::vector<std::string> listen = {"127.0.0.1:0"}, std::string udp_listen = {},
                   std::unique_ptr<hw::Device> device = nullptr,
                   std::optional<server::WebConfig> web = {})
      : scene_(server::load_scene(HAPTIC_SOURCE_DIR "/server/scenes/finger_constant.textproto")),
        unit_(make_unit(scene_, std::move(device))),
        telemetry_({unit_.get()}),
        owner_(telemetry_),
        hand_over_(handed_over({.listen = std::move(listen),
                                .udp_listen = std::move(udp_listen),
                                .web = std::move(web)})),
        front_(hand_over_->start(), with(owner_, *unit_),
               {[] { return server::ServerFacts{}; }, {}, {}}),
        loop_(server::RealtimeRequest{}, std::chrono::milliseconds(1)) {
    telemetry_.allow_watching(loop_.grant().facts.sched_fifo &&
                              std::thread::hardware_concurrency() > 1);
    telemetry_.add(0, &arrivals);
    telemetry_.start();
    front_.start();
    loop_.begin({unit_.get()}, telemetry_.bell());
  }
  ~Product() {
    owner_.begin_closing();
    loop_.finish(std::chrono::seconds(1));
    front_.stop(std::chrono::seconds(1));
    telemetry_.stop();
  }
  [[nodiscard]] std::string address(std::size_t i = 0) const {
    return hand_over_->addresses().at(i);
  }
  [[nodiscard]] std::uint16_t udp_port() const {
    return test::port_of(hand_over_->config().udp_listen);
  }

  Arrivals arrivals;

 private:
  static std::unique_ptr<server::HandOver> handed_over(const server::ServerScene& scene) {
    return std::make_unique<server::HandOver>(server::front_config(scene, false), scene,
                                              "/no/page");
  }
  static server::Owner& with(server::Owner& owner, server::DeviceUnit& unit) {
    owner.add(unit, {});
    return owner;
  }
  static std::unique_ptr<server::DeviceUnit> make_unit(const server::Scene& scene,
                                                       std::unique_ptr<hw::Device> opened) {
    const server::DeviceScene& device = scene.devices.front();
    if (opened == nullptr) opened = device.source->open(device.pipeline.kinematics, {});
    core::PipelineConfig config = server::pipeline_config(device, opened->info().limits);
    config.late_bucket_full = 1'000'000;
    config.loop_late_fault = std::chrono::seconds(5);
    return std::make_unique<server::DeviceUnit>(device.name, std::move(opened), config);
  }
  server::Scene scene_;
  std::unique_ptr<server::DeviceUnit> unit_;
  server::Telemetry telemetry_;
  server::Owner owner_;
  std::unique_ptr<server::HandOver> hand_over_;
  server::FrontServer front_;
  server::Loop loop_;
};

}  // namespace haptic::bench
