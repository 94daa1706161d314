#include "haptic/core/tick/pipeline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "haptic/core/error.hpp"
#include "haptic/core/model/hand_exoskeleton.hpp"
#include "tests/core/model/sample_maps.hpp"
#include "tests/core/tick/finger_bench.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::core {
namespace {

using namespace test;
using std::chrono::milliseconds;

PipelineConfig damped(RendererKind renderer = RendererKind::kSubspaceLinear, bool guard = false) {
  PipelineConfig c = config_of(renderer);
  c.scene.direction_guard = guard;
  c.scene.damping = one(2.0);
  return c;
}

/// Two actuated slides whose springs are coupled.
PipelineConfig coupled_slides() {
  PipelineConfig c = pressing_config(samples::linear_map(MatXQ::Identity(2, 2), 2, 1.0),
                                     RendererKind::kSubspaceLinear);
  c.projection.coupling = std::make_shared<const StiffnessCoupling>(
      (Eigen::Matrix2d() << 900.0, 500.0, 500.0, 600.0).finished());
  c.scene.stiffness = c.projection.coupling->scene_stiffness();
  return c;
}

/// A proxy at smaller flexion than the finger's.
class PipelineBench : public Bench {
 public:
  explicit PipelineBench(const PipelineConfig& config = damped()) : Bench(config) {
    put(two(30 * kDegree, 30 * kDegree));
    target = two(27 * kDegree, 27 * kDegree);
  }
};

TEST(Pipeline, SilenceEndsForceWithin200Ms) {
  for (const double slew : {1e4, 1.0}) {
    PipelineConfig config = damped();
    config.scene.slew_limit = one(slew);
    PipelineBench bench(config);
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

/// tests/report/STUDY.md#bad-numbers, and the borders of the device: in the tick of the fault
/// itself.
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
    cause(bench.input);
    const TickRecord record = bench.tick();
    EXPECT_TRUE(record.faults().has(fault)) << reason(fault);
    EXPECT_EQ(record.life.state, LifecycleState::kFault) << reason(fault);
    EXPECT_EQ(record.effort.tau_a[0], 0.0) << reason(fault);
  }
}

/// A fault of the output is in the record of its tick, and latched from the next one on.
TEST(Pipeline, FaultOfTheOutputLatches) {
  PipelineConfig config = config_of(RendererKind::kSubspaceLinear);
  config.device.q_upper[0] = HUGE_VAL;
  PipelineBench bench(config);
  bench.engage();
  bench.input.device.sample.q[0] = 1e308;  // its rate overflows
  TickRecord record = bench.tick();
  EXPECT_TRUE(record.faults().has(Fault::kOutputNotFinite));
  EXPECT_FALSE(record.life.faults.any());
  EXPECT_EQ(record.effort.tau_a[0], 0.0);
  record = bench.tick();
  EXPECT_TRUE(record.life.faults.has(Fault::kOutputNotFinite));
  EXPECT_EQ(record.life.state, LifecycleState::kFault);
}

/// A long, eventful run of inputs gives the same bits from the same initial state.
/// Whatever comes, tick() judges that nothing is allocated and that it can be replayed.
TEST(Pipeline, AnyCourseReplaysBitForBit) {
  PipelineConfig everything = damped(RendererKind::kSubspaceExact, true);
  everything.force_control.loops = {ForceLoopGains{1.0, 5.0, 0.5, 0.2, 25.0}};
  everything.passivity.tank.enabled = everything.passivity.observer.enabled = true;
  everything.passivity.observer.inertia = one(0.05);
  everything.passivity.device_damping = one(1.0);
  everything.ratings.resize(1);
  everything.ratings[0].power = 0.5;
  everything.ratings[0].rate = 0.1;
  everything.ratings[0].thermal = ThermalParameters{};
  std::vector<PipelineConfig> configs{everything};
  for (const RendererKind kind : kEveryRenderer) configs.push_back(damped(kind, true));
  for (const PipelineConfig& config : configs) {
    PipelineBench bench(config);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> u(0.0, 1.0);
    bench.input.device.sample.tau_measured = VecA::Zero(1);
    bench.engage();
    for (int i = 0; i < 5000; ++i) {
      bench.put(
          two((35 + 20 * std::sin(0.01 * i)) * kDegree, (40 + 25 * std::sin(0.013 * i)) * kDegree));
      bench.target = two((30 + 20 * u(random)) * kDegree, 30 * kDegree);
      bench.mode = u(random) < 0.2 ? ProxyMode::kFree : ProxyMode::kHeld;
      bench.input.settings.id = static_cast<std::uint64_t>(i / 50);
      if (u(random) < 0.01) ++bench.input.command.engage_id;
      if (u(random) < 0.002) ++bench.input.command.release_id;
      if (u(random) < 0.001) ++bench.input.command.stop_id;
      if (u(random) < 0.001) bench.input.device.sample.q[0] = std::nan("");
      if (u(random) < 0.01) {
        bench.input.command.clear = FaultSet(~0U);
        ++bench.input.command.clear_id;
      }
      const bool sample = u(random) < 0.9;
      bench.tick(sample, u(random) < 0.5);
    }
  }
}

/// The rule that every tick of these tests is held to can be broken by any part of a record.
TEST(Pipeline, AnyDifferenceIsNoReplay) {
  PipelineBench bench;
  const TickRecord record = bench.engage();
  void (*const changes[])(TickRecord&) = {[](TickRecord& r) { r.input.loop.skipped ^= 1u; },
                                          [](TickRecord& r) { r.anchor.active_planes ^= 1u; },
                                          [](TickRecord& r) { r.effort.passivity.tank += 1e-18; }};
  EXPECT_TRUE(identical(record, record));
  for (const auto change : changes) {
    TickRecord other = record;
    change(other);
    EXPECT_FALSE(identical(other, record));
  }
}

/// tests/report/STUDY.md#an-hour-of-ticks.
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

/// The pipeline refuses by itself whatever the scene loader would.
TEST(PipelineConfig, MisfitIsRefusedByName) {
  const struct {
    void (*change)(PipelineConfig&);
    const char* says;
  } cases[] = {
      {[](PipelineConfig&) {}, "no error"},
      {[](PipelineConfig& c) { c.scene.force_limit[0] = 41.0; }, "force_limit[0]"},
      {[](PipelineConfig& c) { c.ratings.resize(2); }, "ratings"},
      {[](PipelineConfig& c) {
         c.passivity.tank.enabled = true;
         c.passivity.device_damping = VecA::Ones(3);
       },
       "device_damping"},
      {[](PipelineConfig& c) {
         c.force_control.loops.resize(1);
         c.force_control.cells.resize(2);
       },
       "cell"},
      {[](PipelineConfig& c) {
         c.force_control.loops.resize(1);
         c.force_control.cells = {{.range = -1.0}};
       },
       "range must be > 0"},
      {[](PipelineConfig& c) { c.force_control.cells.resize(1); }, "cell"},
      // core/METHOD.md#hand-without-prior: of eight DoFs and three coordinates.
      {[](PipelineConfig& c) {
         TrackedHandParameters hand;
         hand.fingers.push_back(MountedFinger{HandFinger{"one", finger_sign_change()}, Pose3{}});
         hand.outputs.push_back(
             {"tip", "one", Phalanx::kMiddle, OutputKind::kPoint, {{0.03, 0.0, 0.0}, {}}});
         c.kinematics = make_tracked_hand(hand);
         c.device.q_lower = VecQ::Constant(8, -5.0);
         c.device.q_upper = VecQ::Constant(8, 5.0);
       },
       "prior: must be given"},
      {[](PipelineConfig& c) {
         c = coupled_slides();
         c.scene.renderer = RendererKind::kNullSpace;
       },
       "renderer"},
      {[](PipelineConfig& c) { c.projection.coupling = coupled_slides().projection.coupling; },
       "one per actuated DoF, 1"},
      {[](PipelineConfig& c) {
         c = pressing_config(equal_fingers(2), RendererKind::kSubspaceLinear);
         c.projection.coupling = coupled_slides().projection.coupling;
       },
       "diagonal for a hand"}};
  for (const auto& c : cases) {
    PipelineConfig config = damped();
    c.change(config);
    const std::string text = haptic::test::message_of<SceneError>([&] { return Pipeline{config}; });
    EXPECT_NE(text.find(c.says), std::string::npos) << c.says << ": " << text;
  }
}

}  // namespace
}  // namespace haptic::core
