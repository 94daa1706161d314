/// tests/report/STUDY.md#an-hour-of-ticks.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/core/tick/finger_bench.hpp"

namespace haptic::core::test {
namespace {

TEST(Pipeline, RunsAnHourWithoutAllocating) {
  Bench bench(config_of(RendererKind::kSubspaceExact));
  bench.replays = false;  // for the time that it takes
  std::vector<VecQ> poses;
  for (int i = 0; i < 1000; ++i) {
    const double phase = 2.0 * M_PI * i / 1000;
    bench.put(joints(0.42 + 0.17 * std::sin(phase), 0.52 + 0.21 * std::sin(phase + 0.3)));
    poses.push_back(bench.input.device.sample.q);
  }
  bench.target = joints(0.35, 0.44);
  bench.engage();
  int wrong = 0;  // and tick() judges the allocations
  for (std::size_t i = 0; i < 3'600'000; ++i) {
    bench.input.device.sample.q = poses[i % poses.size()];
    const TickRecord record = bench.tick();
    wrong += std::isfinite(record.effort.tau_a[0]) && record.life.state == LifecycleState::kEngaged
                 ? 0
                 : 1;
  }
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace haptic::core::test
