#include "haptic/core/tick/pipeline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/support/allocation_guard.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

using std::chrono::milliseconds;

/// A finger on virtual time: device and client are the test.
class PipelineBench {
 public:
  explicit PipelineBench(RendererKind renderer = RendererKind::kSubspaceLinear, bool guard = false,
                         double slew = 1e4, SilencePolicy policy = SilencePolicy::kFault)
      : pipeline_(config(renderer, guard, slew, policy)) {
    input_.settings = pipeline_.config().scene;
    put(two(30 * kDegree, 30 * kDegree));
    input_.device.armed = true;
    input_.command.tenure = 1;
    input_.command.lease_held = true;
  }

  static PipelineConfig config(RendererKind renderer, bool guard, double slew,
                               SilencePolicy policy) {
    PipelineConfig c;
    c.kinematics = make_finger_exoskeleton({});
    c.device.q_lower = (VecQ(2) << -0.0025, -1.5).finished();
    c.device.q_upper = (VecQ(2) << 0.0525, 0.85).finished();
    c.device.max_effort = VecA::Constant(1, 40.0);
    c.device.silence_policy = policy;
    c.scene.renderer = renderer;
    c.scene.direction_guard = guard;
    c.scene.stiffness = VecA::Constant(1, 1500.0);
    c.scene.damping = VecA::Constant(1, 2.0);
    c.scene.force_limit = VecA::Constant(1, 20.0);
    c.scene.slew_limit = VecA::Constant(1, slew);
    c.scene.engage_window = VecA::Constant(1, 10.0);
    return c;
  }

  void put(const VecX& x) {
    EXPECT_EQ(pipeline_.config().kinematics->inverse(x, input_.device.sample.q),
              InverseStatus::kExact);
  }

  TickRecord tick(bool sample = true, bool proxy = true) {
    input_.now += milliseconds(1);
    input_.device.fresh = sample;
    if (sample) {
      ++input_.device.sample.seq;
      input_.device.sample.time = input_.now;
    }
    if (proxy) publish();
    inputs.push_back(input_);
    records.push_back(pipeline_.tick(input_));
    return records.back();
  }

  void publish() {
    ProxySnapshot& p = input_.proxy;
    p.mode = mode;
    p.x = target;
    p.tenure = input_.command.tenure;
    if (p.gapless_samples == 0) p.gapless_since = input_.now;
    ++p.seq;
    ++p.gapless_samples;
    p.born = input_.now;
  }

  /// ENGAGED with g = 1.
  TickRecord engage() {
    for (int i = 0; i < 250; ++i) tick();
    ++input_.command.engage_id;
    TickRecord record = tick();
    EXPECT_EQ(record.life.engage.verdict, EngageVerdict::kAccepted);
    for (int i = 0; i < 205; ++i) record = tick();
    EXPECT_EQ(record.life.state, LifecycleState::kEngaged);
    return record;
  }

  Pipeline pipeline_;
  TickInput input_{};
  ProxyMode mode{ProxyMode::kHeld};
  VecX target = two(27 * kDegree, 27 * kDegree);
  std::vector<TickInput> inputs{};
  std::vector<TickRecord> records{};
};

TEST(Pipeline, RendersZqTimesTheDeviation) {
  PipelineBench bench;
  const TickRecord record = bench.engage();
  // Independent: the linearised deviation by Cramer's rule.
  VecX x_probe;
  MatXQ J;
  ASSERT_EQ(bench.pipeline_.config().kinematics->evaluate(record.sensed.q, x_probe, J),
            MapStatus::kOk);
  const VecX dx = bench.target - x_probe;
  const double dq_a = (dx[0] * J(1, 1) - J(0, 1) * dx[1]) / (J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0));
  EXPECT_NEAR(record.effort.tau_a[0], 1500.0 * dq_a, 1e-9);
  EXPECT_LT(record.effort.tau_a[0], 0.0) << "a proxy at smaller flexion opens the finger";
  EXPECT_EQ(record.life.gain, 1.0);
}

TEST(Pipeline, FreeModeGivesNoForce) {
  PipelineBench bench;
  bench.mode = ProxyMode::kFree;
  bench.engage();
  for (int i = 0; i < 50; ++i) {
    bench.put(two((30 + 0.2 * i) * kDegree, 30 * kDegree));
    const TickRecord record = bench.tick();
    ASSERT_EQ(record.effort.tau_a[0], 0.0) << "tick " << i;
    ASSERT_EQ(record.life.state, LifecycleState::kEngaged);
  }
}

TEST(Pipeline, SilenceEndsForceWithin200Ms) {
  for (const double slew : {1e4, 1.0}) {
    PipelineBench bench(RendererKind::kSubspaceLinear, false, slew);
    TickRecord record = bench.engage();
    for (int i = 0; i < 20000 && slew < 10.0; ++i) record = bench.tick();
    ASSERT_LT(record.effort.tau_elastic[0], -1.0);
    double previous = record.effort.tau_elastic[0];
    for (int age = 1; age <= 200; ++age) {
      record = bench.tick(true, false);
      EXPECT_LE(std::abs(record.effort.tau_elastic[0]), std::abs(previous) + 1e-9) << age;
      if (age < 100) {
        EXPECT_EQ(record.life.gain, 1.0) << age << " ms: hold keeps full stiffness";
      }
      if (age >= 180) {
        EXPECT_EQ(record.effort.tau_elastic[0], 0.0) << age;
        EXPECT_EQ(record.life.state, LifecycleState::kArmed) << age;
      }
      EXPECT_EQ(record.life.lost, age == 180) << age;
      previous = record.effort.tau_elastic[0];
    }
    // Samples return: no force without a new Engage.
    for (int i = 0; i < 400; ++i) record = bench.tick();
    EXPECT_EQ(record.effort.tau_elastic[0], 0.0);
    EXPECT_EQ(record.life.state, LifecycleState::kArmed);
  }
}

/// core/METHOD.md#bad-numbers, and the borders of the device: in the tick of the fault itself.
TEST(Pipeline, AnyFaultZeroesItsTick) {
  const std::pair<Fault, void (*)(TickInput&)> faults[] = {
      {Fault::kSampleNotFinite, [](TickInput& in) { in.device.sample.q[0] = std::nan(""); }},
      {Fault::kSampleOutOfRange, [](TickInput& in) { in.device.sample.q[0] = 0.2; }},
      {Fault::kDeviceLost, [](TickInput& in) { in.device.health = DeviceHealth::kLost; }},
      {Fault::kEmergencyStop, [](TickInput& in) { ++in.command.stop_id; }},
      {Fault::kLoopLate, [](TickInput& in) { in.loop.lateness = milliseconds(21); }},
      {Fault::kLateBucketFull, [](TickInput& in) { in.loop.skipped = 20; }}};
  for (const auto& [fault, cause] : faults) {
    PipelineBench bench;
    ASSERT_LT(bench.engage().effort.tau_a[0], -1.0);
    cause(bench.input_);
    const TickRecord record = bench.tick();
    EXPECT_TRUE(record.faults().has(fault)) << reason(fault);
    EXPECT_EQ(record.life.state, LifecycleState::kFault) << reason(fault);
    EXPECT_EQ(record.effort.tau_a[0], 0.0) << reason(fault);
  }
}

/// A fault of the output is in the record of its tick, and latched from the next one on.
TEST(Pipeline, FaultOfTheOutputLatches) {
  PipelineConfig config =
      PipelineBench::config(RendererKind::kSubspaceLinear, false, 1e4, SilencePolicy::kFault);
  config.device.q_upper[0] = HUGE_VAL;
  config.scene.damping[0] = 0.0;
  PipelineBench bench;
  bench.pipeline_ = Pipeline(config);
  bench.input_.settings = config.scene;
  bench.engage();
  bench.input_.device.sample.q[0] = 1e308;  // its rate overflows
  TickRecord record = bench.tick();
  EXPECT_TRUE(record.faults().has(Fault::kOutputNotFinite));
  EXPECT_FALSE(record.life.faults.any());
  EXPECT_EQ(record.effort.tau_a[0], 0.0);
  record = bench.tick();
  EXPECT_TRUE(record.life.faults.has(Fault::kOutputNotFinite));
  EXPECT_EQ(record.life.state, LifecycleState::kFault);
}

/// A long, eventful run of inputs gives the same bits from the same initial state.
TEST(Pipeline, ReplaysBitForBit) {
  for (const RendererKind kind : {RendererKind::kStandard, RendererKind::kNullSpace,
                                  RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact}) {
    PipelineBench bench(kind, true);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> u(0.0, 1.0);
    bench.engage();
    for (int i = 0; i < 5000; ++i) {
      bench.put(
          two((35 + 20 * std::sin(0.01 * i)) * kDegree, (40 + 25 * std::sin(0.013 * i)) * kDegree));
      bench.target = two((30 + 20 * u(random)) * kDegree, 30 * kDegree);
      bench.mode = u(random) < 0.2 ? ProxyMode::kFree : ProxyMode::kHeld;
      if (u(random) < 0.01) ++bench.input_.command.engage_id;
      if (u(random) < 0.002) ++bench.input_.command.release_id;
      if (u(random) < 0.001) bench.input_.device.sample.q[0] = std::nan("");
      if (u(random) < 0.01) {
        bench.input_.command.clear = FaultSet(~0U);
        ++bench.input_.command.clear_id;
      }
      bench.tick(u(random) < 0.9, u(random) < 0.5);
    }
    Pipeline again(PipelineBench::config(kind, true, 1e4, SilencePolicy::kFault));
    for (std::size_t i = 0; i < bench.inputs.size(); ++i) {
      ASSERT_TRUE(identical(again.tick(bench.records[i].input), bench.records[i]))
          << name(kind) << ", tick " << i;
    }
  }
}

TEST(Pipeline, AllocatesNothing) {
  for (const RendererKind kind : {RendererKind::kStandard, RendererKind::kNullSpace,
                                  RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact}) {
    PipelineBench bench(kind, true);
    bench.engage();
    TickInput input = bench.input_;
    TickRecord record = bench.records.back();
    const haptic::test::AllocationGuard guard;
    for (int i = 0; i < 200; ++i) {
      input.now += milliseconds(1);
      input.device.sample.time = input.now;
      input.device.sample.q[0] += 1e-5;
      input.proxy.born = input.now;
      ++input.proxy.seq;
      input.settings.id = static_cast<std::uint64_t>(i / 50);
      input.command.stop_id = i > 150 ? 1 : 0;
      record = bench.pipeline_.tick(input);
    }
    EXPECT_EQ(guard.allocations(), 0u) << name(kind);
    EXPECT_TRUE(record.faults().has(Fault::kEmergencyStop));
  }
}

TEST(PipelineConfig, MisfitIsRefusedByName) {
  PipelineConfig config =
      PipelineBench::config(RendererKind::kSubspaceLinear, false, 1e4, SilencePolicy::kFault);
  config.scene.force_limit[0] = 41.0;
  try {
    Pipeline pipeline(config);
    FAIL();
  } catch (const SceneError& e) {
    EXPECT_NE(std::string(e.what()).find("force_limit[0]"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace haptic::core
