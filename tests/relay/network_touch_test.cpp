/// The force that a finger feels through a delay: hapticd, the relay and a client as processes or
/// threads, against the shadow: the same object at 1 kHz and without a network, on the pipeline of
/// the same scene, along the motion that was recorded.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <mutex>
#include <thread>

#include "haptic/client/contact.hpp"
#include "haptic/core/model/linear.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "server/owner/scene/scene.hpp"
#include "tests/relay/network_row.hpp"
#include "tests/report/rtt_object.hpp"
#include "tests/support/plane_set.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;
using report::RttObject;

constexpr const char* kScene = "finger_soft_grasp";
constexpr double kRounding = 1e-5;  // N

core::PipelineConfig pipeline_of(const std::filesystem::path& scene_file) {
  const server::DeviceScene scene = server::load_scene(scene_file).devices.front();
  const auto device = scene.source->open(scene.pipeline.kinematics, std::chrono::seconds(5));
  return server::pipeline_config(scene, device->info().limits);
}

/// A shadow's tick; 0 while it has no force either.
class Shadow {
 public:
  Shadow(const core::PipelineConfig& config, std::unique_ptr<RttObject> object)
      : pipeline_(config), object_(std::move(object)) {
    input_.settings = pipeline_.config().scene;
    input_.device.fresh = input_.device.armed = true;
    input_.command.tenure = input_.proxy.tenure = 1;
    input_.command.lease_held = true;
    input_.proxy.mode = core::ProxyMode::kPlanes;
  }

  const core::TickRecord& tick(const RecordedTick& at) {
    constexpr report::RttHorizon kAll{1.0, 1e-3};
    const core::Kinematics& map = *pipeline_.config().kinematics;
    const int n_x = map.space().n_x();
    const auto now = core::TimePoint(
        std::chrono::duration_cast<core::Duration>(std::chrono::duration<double>(1.0 + at.time)));
    core::DeviceSample& device = input_.device.sample;
    input_.now = device.time = input_.proxy.born = now;
    input_.proxy.anchored_at = ++device.seq;  // the tick's number
    device.q = core::VecQ(map.layout().n_q());
    device.q[0] = at.slide;
    device.q[device.q.size() - 1] = device.q.size() > 1 ? at.body : at.slide;
    core::VecX x_probe(n_x);
    if (map.position(device.q, x_probe) == core::MapStatus::kOk) {
      object_->advance(at.time, x_probe);
      input_.proxy.x = object_->proxy(at.time, x_probe);
      input_.proxy.planes = plane_set(object_->contacts(at.time, input_.proxy.x, kAll), n_x);
    }
    if (++input_.proxy.seq == 1) input_.proxy.gapless_since = now;
    ++input_.proxy.gapless_samples;
    if (device.seq % 100 == 0 && !engaged_) ++input_.command.engage_id;
    record_ = pipeline_.tick(input_);
    engaged_ = record_.life.state == core::LifecycleState::kEngaged;
    return record_;
  }

 private:
  core::Pipeline pipeline_;
  std::unique_ptr<RttObject> object_;
  core::TickInput input_{};
  core::TickRecord record_{};
  bool engaged_{false};
};

struct Touch {
  int contact{0}, held_back{0};
  int broken{0};                             ///< ticks beyond the bound
  std::vector<double> bounds{};              ///< N, of the ticks that have one
  double rms{0.0}, largest{0.0}, peak{0.0};  ///< N
  [[nodiscard]] double percent() const { return peak > 0.0 ? 100.0 * rms / peak : 0.0; }
  [[nodiscard]] double held_back_pct() const { return 100.0 * held_back / std::max(contact, 1); }
};

/// Where both have all their force and one of them has some.
Touch compare(const std::vector<RecordedTick>& run, Shadow shadow) {
  Touch touch;
  for (const RecordedTick& felt : run) {
    const core::TickRecord& there = shadow.tick(felt);
    const double ideal = there.effort.tau_elastic[0];
    if (felt.gain < 1.0 || there.life.gain < 1.0 || (felt.tau_elastic == 0.0 && ideal == 0.0))
      continue;
    ++touch.contact;
    const double off = std::abs(felt.tau_elastic - ideal);
    touch.rms += off * off;
    touch.largest = std::max(touch.largest, off);
    touch.peak = std::max(touch.peak, std::abs(ideal));
    if (felt.error_bound) {
      touch.bounds.push_back(*felt.error_bound);
      touch.broken += off > *felt.error_bound + kRounding ? 1 : 0;
    }
    touch.held_back += felt.limiters.find("ENERGY_TANK") != std::string::npos ? 1 : 0;
  }
  touch.rms = std::sqrt(touch.rms / std::max(touch.contact, 1));
  return touch;
}

Scenario round_trip(int ms) {
  Scenario link;
  link.name = "round trip of " + std::to_string(ms) + " ms";
  link.duration = 60s;
  link.up.delay = link.down.delay = ms * 1ms / 2;
  return link;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at = values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

class NetworkTouch : public testing::TestWithParam<int> {};

TEST_P(NetworkTouch, DelayIsNotFelt) {
  const Scenario link = round_trip(GetParam());
  Daemon daemon(kScene);
  {
    const Relay relay(relay_to(daemon, link));
    Process grasp(HAPTIC_BINARY_DIR "/client/haptic-example-soft-grasp",
                  {"--server", daemon.behind_relay(), "--carriers", "udp", "--seconds", "20"});
    ASSERT_EQ(grasp.wait(), 0);
  }
  ASSERT_EQ(daemon.stop(), 0);
  const auto scene = std::filesystem::path(HAPTIC_SOURCE_DIR "/server/scenes") /
                     (kScene + std::string(".textproto"));
  const Touch touch =
      compare(read_record(daemon.record()), Shadow(pipeline_of(scene), report::rtt_soft_finger()));
  std::printf("%s: error %.3f N rms, %.2f N at most, of %.1f N; held back in %.2f %% of %.1f s\n",
              link.name.c_str(), touch.rms, touch.largest, touch.peak, touch.held_back_pct(),
              1e-3 * touch.contact);
  const double bounded =
      100.0 * static_cast<double>(touch.bounds.size()) / std::max(touch.contact, 1);
  std::printf("  bound in %.2f %% of contact, median %.4f N, largest %.3f N, broken in %d ticks\n",
              bounded, quantile(touch.bounds, 0.5), quantile(touch.bounds, 1.0), touch.broken);
  EXPECT_EQ(touch.broken, 0);
  EXPECT_GT(bounded, 99.0);
  EXPECT_GT(touch.contact, 1000);
  EXPECT_GT(touch.peak, 5.0);
  if (!host_is_calm()) return;
  EXPECT_LE(touch.rms, 0.15);
  EXPECT_LE(touch.held_back_pct(), 2.0);
}

INSTANTIATE_TEST_SUITE_P(Of, NetworkTouch, testing::Values(0, 20, 100),
                         [](const auto& row) { return std::to_string(row.param) + "ms"; });

// Objects of tests/report/rtt_object.hpp on rails: a device that is led along the motion.

constexpr double kRest = 4.0, kMotion = 8.0;  // s

/// An object, how the device is led on it, and how far off the force may be, % of its peak.
struct OnRails {
  const char* name;
  std::unique_ptr<RttObject> (*object)();
  int n;  ///< rails: l_x, and of two q_B
  std::vector<double> (*led)(double t);
  int round_trip_ms;
  double limit_pct;
};

/// Up to 12 mm into the wall for half of every period, as the study's hand presses.
std::vector<double> into_the_wall(double t) {
  return {-0.012 * std::cos(2.0 * M_PI * 0.7 * t)};
}

/// 6 mm deep into the disc, to and fro by 15 mm with up to 50 mm/s: y and x.
std::vector<double> along_the_disc(double t) {
  const double down = 0.5 - 0.5 * std::cos(M_PI * std::clamp(t, 0.0, 1.0));
  return {0.010 - 0.016 * down, 0.015 * std::sin(2.0 * M_PI * 0.54 * t)};
}

std::unique_ptr<RttObject> light_object() {
  return report::rtt_pushed({.mass = 0.2});
}

const OnRails kObjects[]{
    {"soft_wall", report::rtt_soft_wall, 1, into_the_wall, 0, 1.0},
    {"soft_wall", report::rtt_soft_wall, 1, into_the_wall, 100, 1.0},
    {"stiffening", report::rtt_stiffening_wall, 1, into_the_wall, 100, 4.0},
    {"disc_70mm_s", report::rtt_disc, 2, along_the_disc, 100, 3.0},
    {"pushed_right_0.2kg", light_object, 1, into_the_wall, 100, 2.0},
};

std::string device_of(const OnRails& what, const std::filesystem::path& motion) {
  constexpr double kRow = 0.005;  // s
  std::ofstream file(motion);
  file << (what.n == 1 ? "time_s,l_x\n" : "time_s,l_x,q_B\n");
  for (int i = 0; i * kRow < kRest + kMotion + 8.0; ++i) {
    file << i * kRow;
    for (const double q : what.led(std::clamp(i * kRow - kRest, 0.0, kMotion))) file << ',' << q;
    file << '\n';
  }
  const std::string many = what.n == 1 ? "[1]" : "[1, 1]";
  const auto all = [&](const std::string& value) {
    return what.n == 1 ? "[" + value + "]" : "[" + value + ", " + value + "]";
  };
  std::string device = "name: \"rails\"\nreplay { file: \"" + motion.string() +
                       "\" max_effort: " + all("100") + " }\nlinear {\n";
  for (const char* name : {"l_x", "q_B"}) {
    if (what.n == 1 && name[0] == 'q') continue;
    device += std::string("dof { name: \"") + name +
              "\" unit: \"m\" actuated: true lower: -0.2 upper: 0.2 }\ncoordinate { name: \"x_" +
              name + "\" unit: \"m\" }\n";
  }
  // The first rail of two is y, so that the recorded force is the one that pushes it out.
  device += std::string("A: ") + (what.n == 1 ? "[1]" : "[0, 1, 1, 0]") + " }\n";
  device += "impedance { stiffness_n_per_m: " + all("1500") + " damping_n_s_per_m: " + all("0") +
            " }\nlimits { force_n: " + all("60") + " slew_n_per_s: " + all("100000") +
            " engage_window_n: " + all("60") + " }\npassivity { tank { inertia_kg: " + all("0.3") +
            " } device_damping_n_s_per_m: " + all("2") + " }\n";
  return device;
}

/// A simulation that integrates every state it gets and publishes 60 times a second.
class RemoteObject {
 public:
  RemoteObject(const std::string& address, std::unique_ptr<RttObject> object)
      : object_(std::move(object)), connection_({.address = address}) {
    session_ = connection_.open({
        .client_name = "remote object",
        .nominal_rate_hz = 60.0,
        .carriers = client::Carriers::kUdpOnly,
        .on_state = [this](const client::DeviceState& state) { look(state); },
    });
    session_->engage_when_ready();
  }

  void run(std::chrono::duration<double> length) {
    constexpr auto kPeriod = std::chrono::microseconds(1'000'000 / 60);
    const auto begin = std::chrono::steady_clock::now();
    for (auto next = begin; next < begin + length; next += kPeriod) {
      std::this_thread::sleep_until(next);
      const report::RttHorizon near{
          client::contact_horizon(session_->round_trip(), kPeriod),
          0.5 * std::chrono::duration<double>(session_->round_trip() + kPeriod).count()};
      client::Proxy proxy = client::Proxy::free();
      {
        const std::lock_guard lock(mutex_);
        if (x_probe_.size() == 0) continue;
        const core::VecX x = object_->proxy(time_of(seq_), x_probe_);
        auto planes = object_->contacts(time_of(seq_), x, near);
        if (!planes.empty()) proxy = client::Proxy::behind(std::move(planes), report::to_std(x));
        proxy.device_seq_used = seq_;
      }
      session_->publish(std::move(proxy));
    }
  }

 private:
  static double time_of(std::uint64_t tick) { return 1e-3 * static_cast<double>(tick); }
  void look(const client::DeviceState& state) {
    const std::lock_guard lock(mutex_);
    if (state.x_probe.empty() || state.seq <= seq_) return;
    const core::VecX now = Eigen::Map<const core::VecX>(
        state.x_probe.data(), static_cast<Eigen::Index>(state.x_probe.size()));
    const core::VecX before = x_probe_.size() == 0 ? now : x_probe_;
    const std::uint64_t ticks = x_probe_.size() == 0 ? 1 : state.seq - seq_;
    for (std::uint64_t i = 1; i <= ticks; ++i) {
      const double part = static_cast<double>(i) / static_cast<double>(ticks);
      object_->advance(time_of(state.seq), before + part * (now - before));
    }
    x_probe_ = now;
    seq_ = state.seq;
  }

  std::mutex mutex_{};
  std::unique_ptr<RttObject> object_;
  core::VecX x_probe_{};
  std::uint64_t seq_{0};
  client::Connection connection_;
  std::unique_ptr<client::Session> session_{};
};

class NetworkObject : public testing::TestWithParam<OnRails> {};

TEST_P(NetworkObject, DelayIsNotFelt) {
  const OnRails& what = GetParam();
  const ScratchFolder folder;
  Daemon daemon(Daemon::Device{device_of(what, folder.path() / "motion.csv")});
  {
    const Relay relay(relay_to(daemon, round_trip(what.round_trip_ms)));
    RemoteObject remote(daemon.behind_relay(), what.object());
    remote.run(std::chrono::duration<double>(kRest + kMotion + 0.5));
  }
  ASSERT_EQ(daemon.stop(), 0);
  const auto scene = daemon.record().parent_path() / "scene.textproto";
  const Touch touch =
      compare(read_record(daemon.record()), Shadow(pipeline_of(scene), what.object()));
  std::printf("relay,%s,%d,%.4g,%.4g,%.3g,%.3g,%.3g\n", what.name, what.round_trip_ms, touch.peak,
              touch.rms, touch.percent(), touch.largest, touch.held_back_pct());
  EXPECT_GT(touch.contact, 1000);
  EXPECT_GT(touch.peak, 1.0);
  if (!host_is_calm()) return;
  EXPECT_LE(touch.percent(), what.limit_pct);
}

INSTANTIATE_TEST_SUITE_P(Of, NetworkObject, testing::ValuesIn(kObjects), [](const auto& row) {
  std::string name = row.param.name;
  std::replace(name.begin(), name.end(), '.', '_');
  return name + "_" + std::to_string(row.param.round_trip_ms) + "ms";
});

}  // namespace
}  // namespace haptic::test
