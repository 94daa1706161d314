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
    input_.command.lease_epoch = 1;
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
    p.epoch = input_.command.lease_epoch;
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
    EXPECT_EQ(record.engage.verdict, EngageVerdict::kAccepted);
    for (int i = 0; i < 205; ++i) record = tick();
    EXPECT_EQ(record.state, DeviceState::kEngaged);
    return record;
  }

  Pipeline pipeline_;
  TickInput input_{};
  ProxyMode mode{ProxyMode::kHeld};
  VecX target = two(27 * kDegree, 27 * kDegree);
  std::vector<TickInput> inputs{};
  std::vector<TickRecord> records{};
};

TEST(Pipeline, RendersZqTimesTheDeviationOfTheSubspaceProxy) {
  PipelineBench bench;
  const TickRecord record = bench.engage();
  // Independent: the linearised deviation by Cramer's rule.
  VecX x_probe;
  MatXQ J;
  ASSERT_EQ(bench.pipeline_.config().kinematics->evaluate(record.q, x_probe, J), MapStatus::kOk);
  const VecX dx = bench.target - x_probe;
  const double dq_a = (dx[0] * J(1, 1) - J(0, 1) * dx[1]) / (J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0));
  EXPECT_NEAR(record.tau_a[0], 1500.0 * dq_a, 1e-9);
  EXPECT_LT(record.tau_a[0], 0.0) << "a proxy at smaller flexion opens the finger";
  EXPECT_EQ(record.gain, 1.0);
}

TEST(Pipeline, FreeModeGivesNoForceAndNoDrag) {
  PipelineBench bench;
  bench.mode = ProxyMode::kFree;
  bench.engage();
  for (int i = 0; i < 50; ++i) {
    bench.put(two((30 + 0.2 * i) * kDegree, 30 * kDegree));
    const TickRecord record = bench.tick();
    ASSERT_EQ(record.tau_a[0], 0.0) << "tick " << i;
    ASSERT_EQ(record.state, DeviceState::kEngaged);
  }
}

TEST(Pipeline, SilenceOfTheClientEndsElasticForceIn200msWhateverTheSlewLimit) {
  for (const double slew : {1e4, 1.0}) {
    PipelineBench bench(RendererKind::kSubspaceLinear, false, slew);
    TickRecord record = bench.engage();
    for (int i = 0; i < 20000 && slew < 10.0; ++i) record = bench.tick();
    ASSERT_LT(record.tau_elastic[0], -1.0);
    double previous = record.tau_elastic[0];
    for (int age = 1; age <= 200; ++age) {
      record = bench.tick(true, false);
      EXPECT_LE(std::abs(record.tau_elastic[0]), std::abs(previous) + 1e-9) << age;
      if (age < 100) {
        EXPECT_EQ(record.gain, 1.0) << age << " ms: hold keeps full stiffness";
      }
      if (age >= 180) {
        EXPECT_EQ(record.tau_elastic[0], 0.0) << age;
        EXPECT_EQ(record.state, DeviceState::kArmed) << age;
      }
      EXPECT_EQ(record.lost, age == 180) << age;
      previous = record.tau_elastic[0];
    }
    // Samples return: no force without a new Engage.
    for (int i = 0; i < 400; ++i) record = bench.tick();
    EXPECT_EQ(record.tau_elastic[0], 0.0);
    EXPECT_EQ(record.state, DeviceState::kArmed);
  }
}

TEST(Pipeline, LeavingHoldNeedsNoRampAndLeavingFadeDoes) {
  PipelineBench bench;
  bench.engage();
  for (int i = 0; i < 90; ++i) bench.tick(true, false);
  EXPECT_EQ(bench.tick().gain, 1.0);
  for (int i = 0; i < 140; ++i) bench.tick(true, false);
  const double faded = bench.records.back().gain;
  EXPECT_NEAR(faded, 0.5, 1e-9);
  EXPECT_NEAR(bench.tick().gain, faded + 1.0 / 200.0, 1e-12);
}

TEST(Pipeline, TheEndOfTheLeaseFadesAndThenCommandsZero) {
  PipelineBench bench;
  bench.engage();
  bench.input_.command.lease_held = false;
  TickRecord record = bench.tick(true, false);
  EXPECT_EQ(record.state, DeviceState::kReleasing);
  double g = record.gain;
  for (int i = 0; i < 85; ++i) {
    record = bench.tick(true, false);
    EXPECT_LE(g - record.gain, 1.0 / 80.0 + 1e-9);
    g = record.gain;
  }
  EXPECT_EQ(record.state, DeviceState::kIdle);
  EXPECT_EQ(record.tau_a[0], 0.0);
  EXPECT_FALSE(record.arm);
}

TEST(Pipeline, AFadingForceIsNeverLedByTheNextLease) {
  PipelineBench bench;
  bench.engage();
  const VecX before = bench.records.back().x;
  ++bench.input_.command.lease_epoch;
  bench.input_.proxy.gapless_samples = 0;
  bench.target = two(60 * kDegree, 60 * kDegree);
  for (int i = 0; i < 40; ++i) {
    const TickRecord record = bench.tick();
    ASSERT_EQ(record.state, DeviceState::kReleasing);
    ASSERT_EQ(record.x, before);
  }
  for (int i = 0; i < 60; ++i) bench.tick();
  EXPECT_EQ(bench.records.back().state, DeviceState::kArmed);
  EXPECT_EQ(bench.records.back().x, bench.target);
}

TEST(Pipeline, EngageNamesWhatIsNotGoodEnough) {
  PipelineBench bench;
  const auto ask = [&bench](bool sample = true, bool proxy = true) {
    ++bench.input_.command.engage_id;
    return bench.tick(sample, proxy).engage;
  };
  EXPECT_EQ(ask().verdict, EngageVerdict::kNotArmed);
  for (int i = 0; i < 3; ++i) bench.tick();
  EngageAnswer answer = ask();
  EXPECT_EQ(answer.verdict, EngageVerdict::kTooFewSamples);
  EXPECT_EQ(answer.limit, 10.0);
  for (int i = 0; i < 20; ++i) bench.tick();
  answer = ask();
  EXPECT_EQ(answer.verdict, EngageVerdict::kStreamTooYoung);
  EXPECT_LT(answer.value, 200.0);
  for (int i = 0; i < 250; ++i) bench.tick();
  bench.target = two(5 * kDegree, 5 * kDegree);
  answer = ask();
  EXPECT_EQ(answer.verdict, EngageVerdict::kOutsideWindow);
  EXPECT_GT(answer.value, 10.0);
  EXPECT_EQ(answer.limit, 10.0);
  bench.target = two(27 * kDegree, 27 * kDegree);
  for (int i = 0; i < 4; ++i) bench.tick(false);
  EXPECT_EQ(ask(false).verdict, EngageVerdict::kDeviceStale);
  bench.tick();
  for (int i = 0; i < 105; ++i) bench.tick(true, false);
  answer = ask(true, false);
  EXPECT_EQ(answer.verdict, EngageVerdict::kStreamStale);
  EXPECT_GE(answer.value, 100.0);
  EXPECT_EQ(bench.records.back().gain, 0.0);
}

/// core/METHOD.md#bad-numbers, and the borders of the device.
TEST(Pipeline, WhatTheDeviceMustNotSayIsAFaultWithZeroCommandThatLatches) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  struct Case {
    VecQ q;
    Fault fault;
  };
  const Case cases[] = {{(VecQ(2) << nan, 0.0).finished(), Fault::kSampleNotFinite},
                        {(VecQ(2) << 0.01, HUGE_VAL).finished(), Fault::kSampleNotFinite},
                        {(VecQ(2) << 0.2, 0.0).finished(), Fault::kSampleOutOfRange}};
  for (const Case& c : cases) {
    PipelineBench bench;
    bench.engage();
    const VecQ good = bench.input_.device.sample.q;
    bench.input_.device.sample.q = c.q;
    TickRecord record = bench.tick();
    EXPECT_TRUE(record.faults.has(c.fault));
    EXPECT_EQ(record.state, DeviceState::kFault);
    EXPECT_EQ(record.tau_a[0], 0.0);
    bench.input_.device.sample.q = good;
    record = bench.tick();
    EXPECT_EQ(record.state, DeviceState::kFault) << "latched";
    bench.input_.command.clear.set(c.fault);
    ++bench.input_.command.clear_id;
    record = bench.tick();
    EXPECT_FALSE(record.clear.refused.any());
    EXPECT_EQ(record.state, DeviceState::kIdle);
  }
}

TEST(Pipeline, AClearOfAStopLeavesALaterStopAlone) {
  PipelineBench bench;
  bench.engage();
  ++bench.input_.command.stop_id;
  ASSERT_EQ(bench.tick().state, DeviceState::kFault);
  const std::uint64_t seen = bench.input_.command.stop_id;
  ++bench.input_.command.stop_id;  // somebody else's, whom the clearing one has not heard yet
  bench.tick();
  bench.input_.command.clear.set(Fault::kEmergencyStop);
  bench.input_.command.clear_stop_id = seen;
  ++bench.input_.command.clear_id;
  TickRecord record = bench.tick();
  EXPECT_TRUE(record.clear.refused.has(Fault::kEmergencyStop));
  EXPECT_EQ(record.state, DeviceState::kFault);
  bench.input_.command.clear_stop_id = bench.input_.command.stop_id;
  ++bench.input_.command.clear_id;
  record = bench.tick();
  EXPECT_FALSE(record.clear.refused.any());
  EXPECT_EQ(record.state, DeviceState::kIdle);
}

TEST(Pipeline, ASilentDeviceIsAFaultAndARecordingsGapIsARamp) {
  PipelineBench hardware;
  hardware.engage();
  TickRecord record;
  for (int i = 0; i < 10; ++i) record = hardware.tick(false);
  EXPECT_EQ(record.state, DeviceState::kEngaged) << "q is held up to max_silence";
  EXPECT_EQ(record.q_a_dot[0], 0.0);
  record = hardware.tick(false);
  EXPECT_TRUE(record.faults.has(Fault::kDeviceSilent));
  hardware.input_.command.clear.set(Fault::kDeviceSilent);
  ++hardware.input_.command.clear_id;
  record = hardware.tick(false);
  EXPECT_TRUE(record.clear.refused.has(Fault::kDeviceSilent)) << "the cause persists";

  PipelineBench recording(RendererKind::kSubspaceLinear, false, 1e4, SilencePolicy::kRampOut);
  recording.engage();
  for (int i = 0; i < 100; ++i) record = recording.tick(false);
  EXPECT_EQ(record.state, DeviceState::kEngaged);
  EXPECT_EQ(record.gain, 0.0);
  EXPECT_NEAR(recording.tick().gain, 1.0 / 200.0, 1e-12);
}

TEST(Pipeline, AnEmergencyStopActsInItsTickAndALateLoopIsAFault) {
  PipelineBench bench;
  bench.engage();
  ++bench.input_.command.stop_id;
  TickRecord record = bench.tick();
  EXPECT_TRUE(record.faults.has(Fault::kEmergencyStop));
  EXPECT_EQ(record.tau_a[0], 0.0);

  PipelineBench late;
  late.engage();
  late.input_.loop.lateness = milliseconds(21);
  record = late.tick();
  EXPECT_TRUE(record.faults.has(Fault::kLoopLate));
  EXPECT_EQ(record.tau_a[0], 0.0);

  PipelineBench often;
  often.engage();
  often.input_.loop.skipped = 1;
  for (int i = 0; i < 19; ++i) record = often.tick();
  EXPECT_FALSE(record.faults.any());
  EXPECT_TRUE(often.tick().faults.has(Fault::kLateBucketFull));
}

/// core/METHOD.md#map-without-a-value: the forward map fails; q* is kept and the spring stays
/// alive.
TEST(Pipeline, WhereTheMapFailsTheAnchorIsKept) {
  PipelineConfig config =
      PipelineBench::config(RendererKind::kSubspaceExact, false, 1e6, SilencePolicy::kFault);
  config.device.q_lower[1] = -3.0;
  config.scene.stiffness[0] = 100.0;
  PipelineBench bench(RendererKind::kSubspaceExact, false, 1e6);
  bench.pipeline_ = Pipeline(config);
  bench.input_.settings = config.scene;
  bench.engage();
  const VecQ anchor = bench.records.back().q_star;
  bench.input_.device.sample.q = (VecQ(2) << 0.02, -101 * kDegree).finished();
  const TickRecord record = bench.tick();
  EXPECT_EQ(record.projection, ProjectionStatus::kMapFailed);
  EXPECT_EQ(record.q_star, anchor);
  EXPECT_NEAR(record.tau_elastic[0], 100.0 * (anchor[0] - 0.02), 1e-9);
}

TEST(Pipeline, TheSceneIsTheWidestASessionGets) {
  PipelineBench bench;
  bench.input_.settings.id = 7;
  bench.input_.settings.stiffness[0] = 1e9;
  bench.input_.settings.force_limit[0] = 1e9;
  bench.engage();
  bench.target = two(0.0, 0.0);
  TickRecord record;
  for (int i = 0; i < 50; ++i) record = bench.tick();
  EXPECT_LE(std::abs(record.tau_a[0]), 20.0);
  EXPECT_EQ(record.settings_id, 7u);
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
    EXPECT_TRUE(record.faults.has(Fault::kEmergencyStop));
  }
}

TEST(PipelineConfig, WhatDoesNotFitIsRefusedWithItsName) {
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
