/// What a finger feels through a delay: hapticd, the relay and the shipped soft grasp as processes,
/// against the shadow: the same simulation at 1 kHz and without a network, on the pipeline of the
/// same scene, along the motion that was recorded.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "haptic/core/tick/pipeline.hpp"
#include "server/scene/scene.hpp"
#include "soft_finger.hpp"
#include "tests/relay/network_row.hpp"
#include "tests/support/plane_set.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

constexpr const char* kScene = "finger_soft_grasp";
constexpr double kFar = 1.0;  // m: the shadow tells every pad

/// A shadow's tick; 0 while it has no force either.
class Shadow {
 public:
  Shadow() : pipeline_(config()) {
    input_.settings = pipeline_.config().scene;
    input_.device.fresh = input_.device.armed = true;
    input_.command.tenure = input_.proxy.tenure = 1;
    input_.command.lease_held = true;
    input_.proxy.mode = core::ProxyMode::kPlanes;
  }

  const core::TickRecord& tick(const RecordedTick& at) {
    const auto now = core::TimePoint(
        std::chrono::duration_cast<core::Duration>(std::chrono::duration<double>(1.0 + at.time)));
    core::DeviceSample& device = input_.device.sample;
    input_.now = device.time = input_.proxy.born = now;
    ++device.seq;
    device.q = (core::VecQ(2) << at.slide, at.body).finished();
    core::MatXQ J;
    core::VecX x_probe(2);
    if (pipeline_.config().kinematics->evaluate(device.q, x_probe, J) == core::MapStatus::kOk) {
      const auto step = finger_.step({x_probe[0], x_probe[1]});
      input_.proxy.x = Eigen::Map<const Eigen::Vector2d>(step.x.data());
      input_.proxy.planes = plane_set(finger_.contacts(step.x, kFar), 2);
    }
    if (++input_.proxy.seq == 1) input_.proxy.gapless_since = now;
    ++input_.proxy.gapless_samples;
    if (device.seq % 100 == 0 && !engaged_) ++input_.command.engage_id;
    record_ = pipeline_.tick(input_);
    engaged_ = record_.life.state == core::LifecycleState::kEngaged;
    return record_;
  }

 private:
  static core::PipelineConfig config() {
    const auto file = std::filesystem::path(HAPTIC_SOURCE_DIR "/server/scenes") /
                      (kScene + std::string(".textproto"));
    const server::DeviceScene scene = server::load_scene(file).devices.front();
    const auto device = scene.source->open(scene.pipeline.kinematics, std::chrono::seconds(5));
    return server::pipeline_config(scene, device->info().limits);
  }

  core::Pipeline pipeline_;
  core::TickInput input_{};
  core::TickRecord record_{};
  examples::SoftFinger finger_{};
  bool engaged_{false};
};

struct Touch {
  int contact{0}, held_back{0};
  double rms{0.0}, largest{0.0}, peak{0.0};  ///< N
};

/// Where both have all their force and one of them has some.
Touch compare(const std::vector<RecordedTick>& run) {
  Touch touch;
  Shadow shadow;
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
    touch.held_back += felt.limiters.find("ENERGY_TANK") != std::string::npos ? 1 : 0;
  }
  touch.rms = std::sqrt(touch.rms / std::max(touch.contact, 1));
  return touch;
}

class NetworkTouch : public testing::TestWithParam<int> {};

TEST_P(NetworkTouch, DelayIsNotFelt) {
  Scenario link;
  link.name = "round trip of " + std::to_string(GetParam()) + " ms";
  link.duration = 60s;
  link.up.delay = link.down.delay = GetParam() * 1ms / 2;
  Daemon daemon(kScene);
  {
    const Relay relay(relay_to(daemon, link));
    Process grasp(HAPTIC_BINARY_DIR "/client/haptic-example-soft-grasp",
                  {"--server", daemon.behind_relay(), "--carriers", "udp", "--seconds", "20"});
    ASSERT_EQ(grasp.wait(), 0);
  }
  ASSERT_EQ(daemon.stop(), 0);
  const Touch touch = compare(read_record(daemon.record()));
  const double held_back = 100.0 * touch.held_back / std::max(touch.contact, 1);
  std::printf("%s: error %.3f N rms, %.2f N at most, of %.1f N; held back in %.2f %% of %.1f s\n",
              link.name.c_str(), touch.rms, touch.largest, touch.peak, held_back,
              1e-3 * touch.contact);
  EXPECT_GT(touch.contact, 1000);
  EXPECT_GT(touch.peak, 5.0);
  if (!host_is_calm()) return;
  EXPECT_LE(touch.rms, 0.15);
  EXPECT_LE(held_back, 2.0);
}

INSTANTIATE_TEST_SUITE_P(Of, NetworkTouch, testing::Values(0, 20, 100),
                         [](const auto& row) { return std::to_string(row.param) + "ms"; });

}  // namespace
}  // namespace haptic::test
