// What the next holder of the lease takes over from the one before: nothing that was granted to it.
#include <algorithm>
#include <cmath>

#include "finger_bench.hpp"

namespace haptic::core::test {
namespace {

bool silent;
std::uint32_t epoch;
TimePoint last;  ///< word of a silent client

ProxySnapshot client(ProxySnapshot p) {
  p.epoch = epoch;
  if (silent) p.born = last;
  return p;
}

/// Damping outlives the loss of a client, for the client who was granted force; not for the next.
TEST(NextLease, InheritsNoDamping) {
  PipelineConfig c = config_of(RendererKind::kSubspaceExact);
  c.scene.damping = VecA::Constant(1, 20.0);
  Bench bench(c);
  bench.engage();
  silent = true;
  epoch = 1;
  last = bench.input.proxy.born;
  bench.shape = client;
  TickRecord record;
  for (int i = 0; i < 400; ++i) record = bench.tick();
  ASSERT_EQ(record.state, DeviceState::kArmed);
  silent = false;
  double angle = 0.5;
  const auto largest_damping = [&] {
    double largest = 0.0;
    for (int i = 0; i < 300; ++i) {
      angle += 2e-4;
      bench.put(joints(angle, 0.5));
      largest = std::max(largest, std::abs(bench.tick().tau_damping[0]));
    }
    return largest;
  };
  EXPECT_GT(largest_damping(), 0.01);
  epoch = bench.input.command.lease_epoch = 2;
  EXPECT_EQ(largest_damping(), 0.0);
}

}  // namespace
}  // namespace haptic::core::test
