// Fingers that nothing can hold are not asked for their f
// (core/METHOD.md#model-only-what-a-scene-needs): what the tick answers is to the bit what it
// answers where it asks all of them, and a completed record has all that it left open.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "haptic/core/tick/probe_completion.hpp"
#include "tests/core/tick/moving_hand.hpp"
#include "tests/support/allocation_guard.hpp"

namespace haptic::core {
namespace {

using namespace test;

/// Up to five planes, each on one to three fingers, some of them in the way. Writes which fingers.
void random_planes(std::mt19937_64& random, ProxySnapshot& p, BlockSet& named) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const int count = static_cast<int>(6 * unit(random));
  p.planes.normals.setZero(p.x.size(), count);
  p.planes.offsets.setZero(count);
  named = 0;
  for (int k = 0; k < count; ++k) {
    for (int n = 0; n < 1 + k % 3; ++n) {
      const int finger = static_cast<int>(kFingers * unit(random));
      const int joint = static_cast<int>(2 * unit(random));
      p.planes.normals(2 * finger + joint, k) = unit(random) < 0.8 ? 1.0 : -0.7;
      named |= 1u << finger;
    }
    p.planes.offsets[k] = p.planes.normals.col(k).dot(p.x) + 0.12 * (unit(random) - 0.6);
  }
}

/// The same sample with a plane more, on all fingers and never in the way: all of them are asked.
TickInput asking_all(TickInput input) {
  ProxySnapshot& p = input.proxy;
  if (p.mode != ProxyMode::kFree && p.mode != ProxyMode::kPlanes) return input;
  p.mode = ProxyMode::kPlanes;
  const int count = p.planes.size();
  PlaneSet::Normals normals = PlaneSet::Normals::Ones(p.x.size(), count + 1);
  PlaneSet::Offsets offsets = PlaneSet::Offsets::Constant(count + 1, kFar);
  if (count > 0) normals.leftCols(count) = p.planes.normals;
  if (count > 0) offsets.head(count) = p.planes.offsets;
  p.planes.normals = normals;
  p.planes.offsets = offsets;
  return input;
}

/// These fingers stay where they were in `last`.
void rest(BlockSet fingers, const VecQ& last, TickInput& input) {
  for (int k = 0; k < 2 * kFingers; ++k) {
    if ((fingers >> (k / 2) & 1u) != 0) input.device.sample.q[k] = last[k];
  }
}

void expect_open_exactly(const TickRecord& record, BlockSet open) {
  ASSERT_EQ(record.unprobed, open);
  for (int k = 0; k < 2 * kFingers; ++k) {
    const bool unknown = (open >> (k / 2) & 1u) != 0;
    ASSERT_EQ(std::isnan(record.x_probe[k]), unknown) << k;
    if (record.x.size() > 0) {
      ASSERT_EQ(std::isnan(record.x[k]), unknown) << k;
    }
  }
}

struct Way {
  RendererKind renderer;
  bool guarded, certified;
};

class Unprobed : public testing::TestWithParam<Way> {};

TEST_P(Unprobed, EveryAnswerIsToTheBitThatOfATickWhichAsksAllFingers) {
  const Way& way = GetParam();
  const PipelineConfig config = hand_config(way.renderer, way.guarded, way.certified);
  std::mt19937_64 random(17);
  Pipeline lean(config), full(config);
  ProbeCompletion completion(*config.kinematics);
  MovingHand hand(config);
  BlockSet named = 0;
  int pressed_beside_open = 0, failures_beside_open = 0;
  bool fails = false;
  TickRecord previous;
  for (int i = 0; i < 4000; ++i) {
    const VecQ last = hand.input.device.sample.q;
    hand.advance();
    if (i % 16 == 0) {
      const ProxyMode mode = i < 300 || i % 128 == 64 ? ProxyMode::kFree
                             : i % 128 == 0           ? ProxyMode::kHeld
                                                      : ProxyMode::kPlanes;
      ProxySnapshot& p = hand.sample(mode);
      named = 0;
      if (mode == ProxyMode::kHeld) named = kAllFingers;
      if (mode == ProxyMode::kHeld) p.x.array() -= 0.02;
      if (mode == ProxyMode::kPlanes) random_planes(random, p, named);
    }
    // From time to time one that is named cannot close, while those that are not rest: an anchor
    // kept and no anchor are then the same there.
    if (i % 16 == 8)
      fails = i % 48 == 8 && named != 0 && unstretched(previous, kAllFingers & ~named);
    if (i % 16 == 14) fails = false;
    const int broken = fails ? std::countr_zero(named) : -1;
    const VecX probe = hand.probe();
    if (fails) rest(kAllFingers & ~named, last, hand.input);
    if (fails) break_finger(broken, hand.input);
    const TickInput all = asking_all(hand.input);
    const TickRecord expected = full.tick(all);
    ASSERT_EQ(expected.unprobed, 0u);
    for (int k = 0; k < 2 * kFingers; ++k) {
      const bool rests = fails && (named >> (k / 2) & 1u) == 0;
      const bool stands = rests || k / 2 == broken;
      ASSERT_EQ(expected.x_probe[k], stands ? previous.x_probe[k] : probe[k]) << k;
    }
    previous = expected;
    const haptic::test::AllocationGuard guard;
    TickRecord record = lean.tick(hand.input);
    expect_open_exactly(record, kAllFingers & ~named);
    const bool open = record.unprobed != 0;
    completion.complete(record);
    ASSERT_EQ(guard.allocations(), 0u);
    ASSERT_EQ(record.unprobed, kAllFingers & ~named) << "what the tick did not look at stays told";
    if (open && record.tau_elastic.norm() > 0.5) ++pressed_beside_open;
    if (open && record.projection == ProjectionStatus::kMapFailed) ++failures_beside_open;
    record.input = expected.input;  // what differs by the plane more
    record.proxy_mode = expected.proxy_mode;
    record.unprobed = 0;
    ASSERT_TRUE(identical(record, expected)) << i;
  }
  EXPECT_GT(pressed_beside_open, 300);
  EXPECT_GT(failures_beside_open, 30);
}

INSTANTIATE_TEST_SUITE_P(Ways, Unprobed,
                         testing::Values(Way{RendererKind::kStandard, false, false},
                                         Way{RendererKind::kNullSpace, true, false},
                                         Way{RendererKind::kSubspaceLinear, false, true},
                                         Way{RendererKind::kSubspaceLinear, true, true},
                                         Way{RendererKind::kSubspaceExact, false, false},
                                         Way{RendererKind::kSubspaceExact, true, false}),
                         [](const auto& way) {
                           return std::string(name(way.param.renderer)) +
                                  (way.param.guarded ? "_guarded" : "");
                         });

TEST(UnprobedFinger, WithoutAProxyNothingIsAskedFor) {
  const PipelineConfig config = hand_config(RendererKind::kSubspaceLinear, false);
  Pipeline pipeline(config);
  ProbeCompletion completion(*config.kinematics);
  MovingHand hand(config);
  hand.input.proxy.mode = ProxyMode::kNone;
  hand.advance();
  TickRecord record = pipeline.tick(hand.input);
  expect_open_exactly(record, kAllFingers);
  completion.complete(record);
  EXPECT_EQ(record.x_probe, hand.probe());
  EXPECT_EQ(record.x.size(), 0);
}

TEST(UnprobedFinger, BeforeTheFirstSampleThereIsNothingToAskFor) {
  const PipelineConfig config = hand_config(RendererKind::kSubspaceLinear, false);
  Pipeline pipeline(config);
  TickInput input;
  input.settings = config.scene;
  const TickRecord record = pipeline.tick(input);
  EXPECT_EQ(record.unprobed, 0u);
  EXPECT_EQ(record.x_probe, VecX::Zero(2 * kFingers));
}

/// One device, not a hand: asked in every tick, whatever the proxy.
TEST(UnprobedFinger, AMapWithoutBlocksIsAskedInEveryTick) {
  for (const ProxyMode mode : {ProxyMode::kFree, ProxyMode::kPlanes, ProxyMode::kHeld}) {
    Bench bench(config_of(RendererKind::kSubspaceLinear));
    for (int i = 0; i < 3; ++i) {
      bench.tick();
      bench.input.proxy.mode = mode;
      ++bench.input.proxy.seq;
      const TickRecord record = bench.pipeline.tick(bench.input);
      EXPECT_EQ(record.unprobed, 0u);
      EXPECT_TRUE(record.x_probe.allFinite());
    }
  }
}

/// Weighed together, the fingers are one device.
TEST(UnprobedFinger, WhereTheMetricTiesFingersTogetherAllAreAsked) {
  PipelineConfig config = hand_config(RendererKind::kSubspaceLinear, false);
  Eigen::MatrixXd W = Eigen::MatrixXd::Identity(2 * kFingers, 2 * kFingers);
  W(1, 3) = W(3, 1) = 0.3;
  config.projection.metric = TaskMetric::from_matrix(W);
  Pipeline pipeline(config);
  MovingHand hand(config);
  hand.advance();
  const TickRecord record = pipeline.tick(hand.input);
  EXPECT_EQ(record.unprobed, 0u);
  EXPECT_EQ(record.x_probe, hand.probe());
}

TEST(UnprobedFinger, IsPartOfWhatAReplayMustMatch) {
  const PipelineConfig config = hand_config(RendererKind::kSubspaceExact, true);
  Pipeline pipeline(config);
  MovingHand hand(config);
  hand.advance();
  const TickRecord record = pipeline.tick(hand.input);
  TickRecord other = record;
  EXPECT_TRUE(identical(record, other)) << "nan and all";
  other.unprobed ^= 1u;
  EXPECT_FALSE(identical(record, other));
}

}  // namespace
}  // namespace haptic::core
