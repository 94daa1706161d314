// Low-passes against the noise of the sensors (core/METHOD.md#noise-of-the-sensors).
#include <gtest/gtest.h>

#include <cmath>

#include "core/src/tick/sensing.hpp"
#include "tests/core/tick/finger_bench.hpp"

namespace haptic::core {
namespace {

using std::chrono::milliseconds;

constexpr double kLag = 0.003, kRateLag = 0.002, kActuatedLag = 0.001;  // s

/// The finger's device: l_x is actuated, q_B only sensed.
class SensorFilterTest : public testing::Test {
 protected:
  /// A sample of (l_x, q_B), `after` the last.
  const Sensed& read(double l_x, double q_B, Duration after = milliseconds(1)) {
    in.now += after;
    in.device.fresh = true;
    in.device.sample.time = in.now;
    in.device.sample.q = two(l_x, q_B);
    return now = sensing.step(in, after, {}, kLag);
  }
  PipelineConfig config{[] {
    PipelineConfig c = test::config_of(RendererKind::kSubspaceLinear);
    c.filter = {duration(kLag), duration(kRateLag), duration(kActuatedLag)};
    return c;
  }()};
  Sensing sensing{config};
  TickInput in{.now = TimePoint(milliseconds(1000))};
  Sensed now{};
};

TEST_F(SensorFilterTest, LagsAsDeclaredWhileSlow) {
  for (const int step : {1, 2}) {  // ms
    for (int k = 0; k <= 600; k += step) {
      read(0.02 + 1e-8 * k, 1e-6 * k, milliseconds(step));  // hundredths of slow
    }
    EXPECT_NEAR(now.q[1], 1e-6 * (600 - 1e3 * kLag), 1e-10) << "however samples are spaced";
    EXPECT_NEAR(now.q[0], 0.02 + 1e-8 * (600 - 1e3 * kActuatedLag), 1e-13);
    EXPECT_NEAR(now.q[0] + now.ahead[0], 0.02 + 1e-8 * 600, 1e-16) << "what the tank books";
    EXPECT_NEAR(now.q_a_dot[0], 1e-5, 1e-14);
    read(0.02, 0.0, milliseconds(10));
  }
  for (int k = 1; k <= 60; ++k) read(0.02 + 1e-8 * k * k, 0.0);  // 20 mm/s^2
  EXPECT_NEAR(now.q_a_dot[0], 0.02 * (0.0595 - kRateLag), 1e-7);
}

/// It is late by slow * kLag / 2 at most, at any speed.
TEST_F(SensorFilterTest, MotionIsHardlyLate) {
  const DofSpec& q_B = config.kinematics->dofs()[1];
  const double slow = 0.15 * (q_B.upper - q_B.lower);
  for (const double times : {0.5, 1.0, 4.0}) {
    read(0.02, 0.0, milliseconds(10));
    const double v = times * slow;
    for (int k = 1; k <= 300; ++k) read(0.02, 1e-3 * k * v);
    EXPECT_NEAR(0.3 * v - now.q[1], v * kLag / (1.0 + times * times), 1e-5);
  }
}

TEST_F(SensorFilterTest, JumpIsFollowedAtOnce) {
  read(0.02, 0.0);
  EXPECT_NEAR(read(0.02, 0.4).q[1], 0.4, 1e-3);
  EXPECT_NEAR(read(0.02, -0.4).q[1], -0.4, 1e-3);
}

TEST_F(SensorFilterTest, BeginsAtTheReading) {
  EXPECT_EQ(read(0.02, 0.1).q[1], 0.1) << "the first one";
  EXPECT_NE(read(0.02, 0.101, milliseconds(3)).q[1], 0.101);
  EXPECT_EQ(read(0.0201, 0.103, milliseconds(4)).q, two(0.0201, 0.103)) << "after a gap";
  EXPECT_EQ(now.ahead, one(0.0));
  EXPECT_EQ(now.q_a_dot, one(0.0));
  EXPECT_EQ(read(0.0201, 0.104, Duration::zero()).q[1], 0.104) << "time stands still";
}

TEST_F(SensorFilterTest, RefusedReadingsLeaveNoTrace) {
  read(0.02, 0.1);
  const double before = read(0.02, 0.101).q[1];
  for (const double bad : {std::nan(""), HUGE_VAL, 1.5}) {
    EXPECT_TRUE(read(0.02, bad).faults.any());
    EXPECT_TRUE(now.refused);
    EXPECT_EQ(now.q[1], before);
  }
  in.device.fresh = false;
  in.now += milliseconds(1);
  EXPECT_TRUE(sensing.step(in, milliseconds(1), {}, kLag).refused) << "still the newest";
  EXPECT_LT(std::abs(read(0.02, 0.101).q[1] - 0.101), std::abs(before - 0.101));
  EXPECT_FALSE(now.refused);
}

/// In a press at 1500 N/m what is left of the steps of the force: by 0.05 degrees rms of q_B, and
/// 5 um rms of l_x.
TEST(SensorFilter, NoiseHardlyReachesForce) {
  const auto ripple = [](SensorFilter filter, const VecQ& noise) {
    PipelineConfig config = test::config_of(RendererKind::kSubspaceLinear);
    config.filter = filter;
    test::Bench bench(config);
    bench.engage();
    bench.target = test::joints(0.45, 0.5);
    bench.run(50);
    const VecQ q = bench.input.device.sample.q;
    double last = bench.record.effort.tau_a[0], sum = 0.0;
    for (int k = 0; k < 400; ++k) {  // -1, +1 and 0 in an order that has no low frequency
      bench.input.device.sample.q = q + (k % 3 - 1) * noise;
      const double tau = bench.tick().effort.tau_a[0];
      sum += (tau - last) * (tau - last);
      last = tau;
    }
    EXPECT_GT(std::abs(last), 0.1);
    return std::sqrt(sum / 400);
  };
  const VecQ q_B = two(0.0, 1e-3), l_x = two(6e-6, 0.0);
  EXPECT_LT(ripple(kDefaultFilter, q_B), 0.1 * ripple({}, q_B));
  EXPECT_LT(ripple(kDefaultFilter, l_x), 0.3 * ripple({}, l_x));
}

/// A lag of the spring gives energy in every cycle of a slow motion, 0.9 mJ in 8 s: it is booked.
TEST(SensorFilter, TankPaysForTheLag) {
  const auto given = [](double tank) {
    PipelineConfig config = test::with_tank(RendererKind::kSubspaceExact, tank);
    config.passivity.device_damping = VecA{};
    config.filter.actuated_lag = milliseconds(20);
    test::Bench bench(config);
    bench.engage();
    double& l_x = bench.input.device.sample.q[0];
    const double rest = l_x;
    double sum = 0.0, most = 0.0;
    for (int k = 1; k <= 8000; ++k) {
      const double to = rest + 1e-3 * std::sin(3e-3 * k);
      sum += bench.record.effort.tau_a[0] * (to - l_x);
      most = std::max(most, sum);
      l_x = to;
      bench.tick();
    }
    return most;
  };
  EXPECT_GT(given(0.005), 5e-4);
  EXPECT_LE(given(1e-4), 1e-4 + 1e-7);
}

}  // namespace
}  // namespace haptic::core
