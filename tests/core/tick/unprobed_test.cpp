// Fingers that nothing can hold are not asked for their f (METHOD 7): what the tick answers is to the
// bit what it answers where it asks all of them, and a completed record has all that it left open.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "haptic/core/tick/probe_completion.hpp"
#include "tests/core/model/sample_hands.hpp"
#include "tests/core/tick/finger_bench.hpp"
#include "tests/support/allocation_guard.hpp"

namespace haptic::core {
namespace {

using namespace test;

constexpr int kFingers = 5;
constexpr BlockSet kAllFingers = (1u << kFingers) - 1;
constexpr double kFar = 1e3;  // rad; no finger bends that far

PipelineConfig hand_config(RendererKind renderer, bool guarded, bool certified = false) {
  PipelineConfig c;
  c.kinematics = make_hand_exoskeleton(five_fingers());
  c.device.q_lower = VecQ::Constant(2 * kFingers, -2.0);
  c.device.q_upper = VecQ::Constant(2 * kFingers, 2.0);
  c.device.max_effort = VecA::Constant(kFingers, 40.0);
  c.scene.renderer = renderer;
  c.scene.direction_guard = guarded;
  c.passivity.tank.enabled = guarded;
  c.passivity.tank.initial = 1e-3;
  c.passivity.observer.enabled = guarded;
  c.passivity.device_damping = VecA::Constant(kFingers, 2.0);
  c.passivity.observer.inertia = VecA::Constant(kFingers, 0.05);
  c.passivity_certificate = certified;
  c.scene.stiffness = VecA::LinSpaced(kFingers, 800.0, 1600.0);
  c.scene.damping = VecA::Constant(kFingers, 2.0);
  c.scene.force_limit = VecA::Constant(kFingers, kForceLimit);
  c.scene.slew_limit = VecA::Constant(kFingers, 2000.0);
  c.scene.engage_window = VecA::Constant(kFingers, 1e3);
  return c;
}

/// One hand in virtual time, whose fingers all move; the proxy is what `sample` was set to last.
class MovingHand {
 public:
  explicit MovingHand(const PipelineConfig& config) : map(*config.kinematics) {
    input.settings = config.scene;
    input.device.armed = input.device.fresh = true;
    input.command.lease_epoch = 1;
    input.command.lease_held = true;
    input.proxy.epoch = 1;
    sample(ProxyMode::kFree);
  }
  void advance() {
    const double phase = 0.02 * n_++;
    VecX angles(2 * kFingers);
    for (int f = 0; f < kFingers; ++f) {
      angles[2 * f] = 0.4 + 0.12 * std::sin(phase + f);
      angles[2 * f + 1] = 0.5 + 0.12 * std::sin(1.3 * phase + 2 * f);
    }
    EXPECT_EQ(map.inverse(angles, input.device.sample.q), InverseStatus::kExact);
    input.now += std::chrono::milliseconds(1);
    ++input.device.sample.seq;
    input.device.sample.time = input.now;
    input.command.engage_id = n_ > 260 ? 1 : 0;
  }
  /// A new frame of the client.
  ProxySnapshot& sample(ProxyMode mode) {
    ProxySnapshot& p = input.proxy;
    p.mode = mode;
    if (++p.seq == 1) p.gapless_since = input.now;
    ++p.gapless_samples;
    p.born = input.now;
    p.x = input.device.sample.q.size() > 0 ? probe() : VecX(VecX::Zero(2 * kFingers));
    p.planes = {};
    return p;
  }
  [[nodiscard]] VecX probe() const {
    VecX x;
    MatXQ J;
    EXPECT_EQ(map.evaluate(input.device.sample.q, x, J), MapStatus::kOk);
    return x;
  }

  const Kinematics& map;
  TickInput input{};

 private:
  int n_{0};
};

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
  int pressed_beside_open = 0;
  for (int i = 0; i < 4000; ++i) {
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
    const TickInput all = asking_all(hand.input);
    const TickRecord expected = full.tick(all);
    ASSERT_EQ(expected.unprobed, 0u);
    ASSERT_EQ(expected.x_probe, hand.probe());
    const haptic::test::AllocationGuard guard;
    TickRecord record = lean.tick(hand.input);
    expect_open_exactly(record, kAllFingers & ~named);
    const bool open = record.unprobed != 0;
    completion.complete(record);
    ASSERT_EQ(guard.allocations(), 0u);
    ASSERT_EQ(record.unprobed, kAllFingers & ~named) << "what the tick did not look at stays told";
    if (open && record.tau_elastic.norm() > 0.5) ++pressed_beside_open;
    record.input = expected.input;  // what differs by the plane more
    record.proxy_mode = expected.proxy_mode;
    record.unprobed = 0;
    ASSERT_TRUE(identical(record, expected)) << i;
  }
  EXPECT_GT(pressed_beside_open, 300);
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

/// METHOD 6, case 17, in a finger that nothing can hold: the others do not notice. Where a plane
/// comes to name it, they do, as with a finger that was asked all the time.
TEST(UnprobedFinger, OneThatCannotCloseDisturbsNobodyUntilAPlaneNamesIt) {
  const PipelineConfig config = hand_config(RendererKind::kSubspaceLinear, true);
  Pipeline sound(config), broken(config);
  ProbeCompletion completion(*config.kinematics);
  MovingHand hand(config);
  constexpr BlockSet kMiddle = 1u << 2;
  const auto planes_on = [&](std::initializer_list<int> fingers) {
    ProxySnapshot& p = hand.sample(ProxyMode::kPlanes);
    p.planes.normals.setZero(p.x.size(), static_cast<Eigen::Index>(fingers.size()));
    p.planes.offsets.setConstant(static_cast<Eigen::Index>(fingers.size()), 0.36);
    int k = 0;
    for (const int finger : fingers) p.planes.normals(2 * finger + 1, k++) = 1.0;
  };
  const auto break_middle = [](TickInput input) {
    input.device.sample.q[4] = 0.02;
    input.device.sample.q[5] = -101 * 0.017453292519943295;
    return input;
  };
  VecX before;
  double most = 0.0;
  for (int i = 0; i < 900; ++i) {
    hand.advance();
    if (i % 16 == 0) planes_on({0});
    const TickRecord expected = sound.tick(hand.input);
    TickRecord record = broken.tick(i < 600 ? hand.input : break_middle(hand.input));
    ASSERT_EQ(record.unprobed, kAllFingers & ~1u);
    completion.complete(record);
    if (i == 599) before = record.x_probe;
    if (i < 600) continue;
    ASSERT_FALSE(record.faults.any());
    ASSERT_EQ(record.projection, expected.projection);
    ASSERT_EQ(record.tau_elastic, expected.tau_elastic);
    for (int k = 0; k < 2 * kFingers; ++k) {
      ASSERT_EQ(record.x_probe[k], k / 2 == 2 ? before[k] : hand.probe()[k]) << k;
    }
    ASSERT_EQ(record.x[4], before[4]) << "free: the proxy is where the probe was last";
    most = std::max(most, record.tau_elastic.cwiseAbs().maxCoeff());
  }
  EXPECT_GT(most, 1.0);

  planes_on({0, 2});
  hand.advance();
  TickRecord named = broken.tick(break_middle(hand.input));
  EXPECT_EQ(named.projection, ProjectionStatus::kMapFailed);
  EXPECT_NE(named.unprobed & kMiddle, 0u) << "asked for, and without an answer so far";
  completion.complete(named);
  EXPECT_EQ(named.x_probe[4], before[4]);
  EXPECT_TRUE(named.x.allFinite());

  hand.advance();  // and back: f is there in this very tick
  TickRecord healed = broken.tick(hand.input);
  EXPECT_NE(healed.projection, ProjectionStatus::kMapFailed);
  EXPECT_EQ(healed.unprobed & (kMiddle | 1u), 0u);
  EXPECT_EQ(VecX(healed.x_probe.segment(4, 2)), VecX(hand.probe().segment(4, 2)));
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
