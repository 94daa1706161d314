#include "core/src/tick/sensing.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/tick/finger_bench.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

using std::chrono::milliseconds;

/// The finger's device, with one sample of every millisecond.
class SensingTest : public testing::Test {
 protected:
  explicit SensingTest() : config(test::config_of(RendererKind::kSubspaceLinear)) {}
  Sensed step(Sensing& sensing, bool fresh = true) {
    in.now += milliseconds(1);
    in.device.fresh = fresh;
    if (fresh) in.device.sample.time = in.now;
    return sensing.step(in, milliseconds(1), driven, 0.0);
  }
  PipelineConfig config;
  Driven driven{};
  TickInput in{.now = TimePoint(milliseconds(1000)), .device = {.sample = {.q = two(0.02, 0.1)}}};
};

TEST_F(SensingTest, TakesQAndItsRate) {
  Sensing sensing(config);
  EXPECT_FALSE(step(sensing, false).ready);
  Sensed now = step(sensing);
  EXPECT_TRUE(now.ready && now.fresh && now.recent);
  EXPECT_EQ(now.q, two(0.02, 0.1));
  EXPECT_EQ(now.q_a_dot, one(0.0)) << "one sample has no rate";
  in.device.sample.q[0] += 1e-5;
  now = step(sensing);
  EXPECT_NEAR(now.q_a_dot[0], 0.01, 1e-12) << "m/s";
  EXPECT_FALSE(now.faults.any());
}

TEST_F(SensingTest, BadSampleFaultsAndIsIgnored) {
  const struct {
    VecQ q;
    Fault fault;
  } cases[] = {{two(std::nan(""), 0.0), Fault::kSampleNotFinite},
               {two(0.01, HUGE_VAL), Fault::kSampleNotFinite},
               {one(0.01), Fault::kSampleNotFinite},
               {two(0.2, 0.0), Fault::kSampleOutOfRange}};
  for (const auto& c : cases) {
    Sensing sensing(config);
    in.device.sample.q = two(0.02, 0.1);
    static_cast<void>(step(sensing));
    in.device.sample.q = c.q;
    const Sensed now = step(sensing);
    EXPECT_TRUE(now.faults.has(c.fault));
    EXPECT_EQ(now.q, two(0.02, 0.1));
    EXPECT_FALSE(now.fresh);
    EXPECT_TRUE(now.ready);
  }
}

TEST_F(SensingTest, ForceControlNeedsAMeasuredForce) {
  Sensing plain(config);
  EXPECT_FALSE(step(plain).faults.any()) << "without a loop none is needed";
  in.device.sample.tau_measured = one(std::nan(""));
  EXPECT_TRUE(step(plain).faults.has(Fault::kSampleNotFinite)) << "but it must be a number";
  in.device.sample.tau_measured = VecA{};
  config.force_control.loops.resize(1);
  Sensing sensing(config);
  EXPECT_TRUE(step(sensing).faults.has(Fault::kSampleNotFinite)) << "none";
  in.device.sample.tau_measured = one(std::nan(""));
  EXPECT_TRUE(step(sensing).faults.has(Fault::kSampleNotFinite));
  in.device.sample.tau_measured = one(3.0);
  EXPECT_EQ(step(sensing).tau_measured, one(3.0));
  EXPECT_EQ(step(sensing, false).tau_measured, one(3.0)) << "held as q is";
}

TEST_F(SensingTest, RateEndsAfterThreeSilentPeriods) {
  Sensing sensing(config);
  static_cast<void>(step(sensing));
  in.device.sample.q[0] += 1e-5;
  static_cast<void>(step(sensing));
  for (int i = 1; i <= 3; ++i) EXPECT_GT(step(sensing, false).q_a_dot[0], 0.0) << i;
  const Sensed now = step(sensing, false);
  EXPECT_FALSE(now.recent);
  EXPECT_EQ(now.q_a_dot, one(0.0));
  EXPECT_EQ(now.age, milliseconds(4));
}

TEST_F(SensingTest, SilenceFaultsUnlessReplayed) {
  for (const SilencePolicy policy : {SilencePolicy::kFault, SilencePolicy::kRampOut}) {
    config.device.silence_policy = policy;
    Sensing sensing(config);
    static_cast<void>(step(sensing));
    for (int i = 1; i <= 10; ++i) EXPECT_FALSE(step(sensing, false).silent) << i;
    const Sensed now = step(sensing, false);
    EXPECT_TRUE(now.silent);
    EXPECT_EQ(now.faults.has(Fault::kDeviceSilent), policy == SilencePolicy::kFault);
  }
}

TEST_F(SensingTest, DeviceReportsLossAndExcessForce) {
  Sensing sensing(config);
  in.device.health = DeviceHealth::kLost;
  EXPECT_TRUE(step(sensing).faults.has(Fault::kDeviceLost));
  in.device.health = DeviceHealth::kForceOverLimit;
  EXPECT_TRUE(step(sensing).faults.has(Fault::kForceOverLimit));
}

}  // namespace
}  // namespace haptic::core
