/// The force that a finger feels through a delay: hapticd, the relay and a client as processes or
/// threads, against the shadow: the same object at 1 kHz and without a network, on the pipeline of
/// the same scene, along the motion that was recorded.

#include <gtest/gtest.h>

#include <cstdio>

#include "client/examples/soft_finger.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "server/owner/scene/scene.hpp"
#include "tests/relay/network_row.hpp"
#include "tests/report/analysis/shadow_judge.hpp"
#include "tests/support/plane_set.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

constexpr const char* kScene = "finger_soft_grasp";

/// The simulation of the example, which looks at every tick.
class Shadow {
 public:
  Shadow() {
    input_.settings = pipeline_.config().scene;
    input_.device.fresh = input_.device.armed = true;
    input_.command.tenure = proxy_.tenure = 1;
    input_.command.lease_held = true;
    proxy_.mode = core::ProxyMode::kPlanes;
  }

  const core::TickRecord& tick(const RecordedTick& at) {
    constexpr double kAll = 1.0;  // m
    const auto now = core::TimePoint(
        std::chrono::duration_cast<core::Duration>(std::chrono::duration<double>(1.0 + at.time)));
    core::DeviceSample& device = input_.device.sample;
    input_.now = device.time = proxy_.born = now;
    proxy_.anchored_at = ++device.seq;  // the tick's number
    device.q = two(at.slide, at.body);
    core::VecX x_probe(2);
    if (pipeline_.config().kinematics->position(device.q, x_probe) == core::MapStatus::kOk) {
      const auto x = finger_.step({x_probe[0], x_probe[1]}).x;
      proxy_.x = two(x[0], x[1]);
      proxy_.planes = plane_set(finger_.contacts(x, kAll), 2);
    }
    if (++proxy_.seq == 1) proxy_.gapless_since = now;
    ++proxy_.gapless_samples;
    if (device.seq % 100 == 0 && !engaged_) ++input_.command.engage_id;
    record_ = pipeline_.tick(input_, proxy_);
    engaged_ = record_.life.state == core::LifecycleState::kEngaged;
    return record_;
  }

 private:
  static core::PipelineConfig config() {
    const server::DeviceScene scene =
        server::load_scene(std::string(HAPTIC_SOURCE_DIR "/server/scenes/") + kScene + ".textproto")
            .devices.front();
    const auto device = scene.source->open(scene.pipeline.kinematics, std::chrono::seconds(5));
    core::PipelineConfig config = server::pipeline_config(scene, device->info().limits);
    config.filter = {.rate_lag = config.filter.rate_lag};  // the recording has what came of them
    return config;
  }

  core::Pipeline pipeline_{config()};
  examples::SoftFinger finger_{};
  core::TickInput input_{};
  core::ProxySnapshot proxy_{};
  core::TickRecord record_{};
  bool engaged_{false};
};

/// Where both have all their force and one of them has some.
report::ShadowFigures compare(const std::vector<RecordedTick>& run) {
  Shadow shadow;
  report::ShadowJudge judge;
  for (const RecordedTick& felt : run) {
    const core::TickRecord& there = shadow.tick(felt);
    if (felt.gain < 1.0 || there.life.gain < 1.0) continue;
    const double ideal = there.effort.tau_elastic[0];
    judge.add({.felt = one(felt.tau_elastic),
               .shadow = one(ideal),
               .elastic = one(felt.tau_elastic),
               .touching = felt.tau_elastic != 0.0 || ideal != 0.0,
               .held_back = felt.limiters.find("ENERGY_TANK") != std::string::npos,
               .bound = felt.error_bound ? one(*felt.error_bound) : core::VecA()});
  }
  return judge.figures();
}

Scenario round_trip(int ms) {
  Scenario link;
  link.name = "round trip of " + std::to_string(ms) + " ms";
  link.duration = 60s;
  link.up.delay = link.down.delay = ms * 1ms / 2;
  return link;
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
  const report::ShadowFigures touch = compare(read_record(daemon.record()));
  std::printf("%s: error %.3f N rms, %.2f N at most, of %.1f N; held back in %.2f %% of %ld ms\n",
              link.name.c_str(), touch.error, touch.largest, touch.peak, 100.0 * touch.held_back,
              touch.ticks);
  std::printf("  bound in %.2f %% of contact, median %.4f N, kept in %.2f %%\n",
              100.0 * touch.bounded, touch.bound_median, 100.0 * touch.kept);
  EXPECT_EQ(touch.kept, 1.0);
  EXPECT_GT(touch.bounded, 0.6);
  EXPECT_GT(touch.ticks, 1000);
  EXPECT_GT(touch.peak, 5.0);
  if (!host_is_calm()) return;
  EXPECT_LE(touch.error, 0.15);
  EXPECT_LE(touch.held_back, 0.02);
}

INSTANTIATE_TEST_SUITE_P(Of, NetworkTouch, testing::Values(0, 20, 100),
                         [](const auto& row) { return std::to_string(row.param) + "ms"; });

}  // namespace
}  // namespace haptic::test
