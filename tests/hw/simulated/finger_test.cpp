/// A finger alone on the simulated hand.
#include "hw/simulated/hand.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/linear.hpp"
#include "tests/hw/simulated/one_finger.hpp"
#include "tests/hw/virtual_loop.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::hw {
namespace {

using namespace std::chrono_literals;
using test::VirtualLoop;

SimulatedHandConfig aiming_at(double mcp, double pip) {
  SimulatedHandConfig config;
  config.target = Eigen::Vector2d(mcp, pip);
  return config;
}

/// A device that aims there, in a loop.
struct Aiming {
  explicit Aiming(const SimulatedHandConfig& config) : device(config, test::one_finger()) {}
  Aiming(double mcp, double pip) : Aiming(aiming_at(mcp, pip)) {}
  SimulatedHand device;
  VirtualLoop loop{device};
};

TEST(SimulatedFinger, StandingTimeGivesNoSample) {
  SimulatedHand device(aiming_at(0.5, 0.5), test::one_finger());
  core::DeviceReading reading;
  device.read(core::TimePoint(1s), reading);
  device.read(core::TimePoint(1s), reading);
  EXPECT_FALSE(reading.fresh);
  EXPECT_EQ(reading.sample.seq, 1u);
  device.read(core::TimePoint(900ms), reading);
  EXPECT_FALSE(reading.fresh);
}

TEST(SimulatedFinger, ThePeriodDoesNotMatter) {
  // The same physics seen through another period and with jitter: the same pose at the same time.
  const auto pose = [](core::Duration period, core::Duration jitter) {
    SimulatedHand device(aiming_at(0.9, 0.8), test::one_finger());
    core::DeviceReading reading;
    const core::TimePoint start(5s);
    bool odd = false;
    for (core::Duration t = 0s; t < 600ms; t += period) {
      device.read(start + t + (odd && t > 0s ? jitter : 0ns), reading);
      odd = !odd;
    }
    device.read(start + 600ms, reading);
    return reading.sample.q;
  };
  const core::VecQ reference = pose(1ms, 0ns);
  EXPECT_EQ(pose(2ms, 0ns)[0], reference[0]);
  EXPECT_EQ(pose(500us, 123us)[1], reference[1]);
}

TEST(SimulatedFinger, RatesAreSmoothUnderJitter) {
  // Times off the 0.1 ms grid of the physics must not show as speed.
  SimulatedHand device(aiming_at(0.9, 0.8), test::one_finger());
  core::DeviceReading reading;
  core::TimePoint now(1s), last_time{};
  double last_q = 0.0, last_rate = 0.0, roughest = 0.0, fastest = 0.0;
  for (int i = 0; i < 800; ++i) {
    now += 1ms + ((i * 7919) % 83 - 41) * 1us;
    device.read(now, reading);
    const double rate = (reading.sample.q[0] - last_q) / core::seconds(now - last_time);
    if (i > 2) roughest = std::max(roughest, std::abs(rate - last_rate));
    if (i > 1) fastest = std::max(fastest, std::abs(rate));
    last_q = reading.sample.q[0];
    last_time = now;
    last_rate = rate;
  }
  EXPECT_GT(fastest, 0.02);
  EXPECT_LT(roughest, 0.02 * fastest);
}

TEST(SimulatedFinger, ArmingTakesOneTick) {
  Aiming aiming(0.5, 0.5);
  auto& [device, loop] = aiming;
  EXPECT_FALSE(loop.tick().armed);
  loop.push(5.0);
  EXPECT_FALSE(loop.tick().armed);
  EXPECT_EQ(device.tau_a()[0], 0.0) << "a device that is arming follows no force";
  EXPECT_TRUE(loop.tick().armed);
  EXPECT_EQ(device.tau_a()[0], 5.0);
  loop.disarm();
  EXPECT_TRUE(loop.tick().armed);
  EXPECT_EQ(device.tau_a()[0], 0.0);
  EXPECT_FALSE(loop.tick().armed);
}

TEST(SimulatedFinger, ForceStaysWithinTheActuatorsLimit) {
  Aiming aiming(0.5, 0.5);
  auto& [device, loop] = aiming;
  loop.push(1e6);
  loop.run(3ms);
  EXPECT_EQ(device.tau_a()[0], 40.0);
  loop.push(-1e6);
  loop.tick();
  EXPECT_EQ(device.tau_a()[0], -40.0);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    loop.push(bad);
    loop.tick();
    EXPECT_EQ(device.tau_a()[0], 0.0);
  }
  loop.run(50ms);
  EXPECT_TRUE(loop.reading().sample.q.allFinite());
}

TEST(SimulatedFinger, AClosedDeviceIsLost) {
  Aiming aiming(0.5, 0.5);
  auto& [device, loop] = aiming;
  loop.push(5.0);
  loop.run(5ms);
  device.close();
  device.close();
  loop.run(5ms);
  EXPECT_EQ(loop.reading().health, core::DeviceHealth::kLost);
  EXPECT_FALSE(loop.reading().fresh);
  EXPECT_FALSE(loop.reading().armed);
  EXPECT_EQ(device.tau_a()[0], 0.0);
}

TEST(SimulatedFinger, NoiseHasSizeWithoutMean) {
  SimulatedHandConfig config = aiming_at(0.0, 0.0);
  config.noise_l_x = 2e-5;
  config.noise_q_B = 3e-3;
  Aiming aiming(config);
  auto& [device, loop] = aiming;
  constexpr int kSamples = 20000;
  Eigen::Array2d sum = Eigen::Array2d::Zero(), square = Eigen::Array2d::Zero();
  double product = 0.0;
  int within_one = 0;
  const core::VecQ truth = device.fingers()[0].q();  // at rest on its aim: it stays
  for (int i = 0; i < kSamples; ++i) {
    const core::VecQ q = loop.tick().sample.q;
    const Eigen::Array2d z((q[0] - truth[0]) / 2e-5, (q[1] - truth[1]) / 3e-3);
    sum += z;
    square += z * z;
    product += z[0] * z[1];
    within_one += std::abs(z[0]) < 1.0 ? 1 : 0;
  }
  // Bounds of five standard errors of n = 20000 normal samples.
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(sum[i] / kSamples, 0.0, 5.0 / std::sqrt(kSamples));
    EXPECT_NEAR(square[i] / kSamples, 1.0, 5.0 * std::sqrt(2.0 / kSamples));
  }
  EXPECT_NEAR(product / kSamples, 0.0, 5.0 / std::sqrt(kSamples));
  EXPECT_NEAR(within_one / double(kSamples), 0.6827, 5.0 * std::sqrt(0.6827 * 0.3173 / kSamples));
}

TEST(SimulatedFinger, SamplesAreMultiplesOfTheResolution) {
  SimulatedHandConfig config = aiming_at(0.8, 0.8);
  config.resolution_l_x = 5e-5;
  config.resolution_q_B = 2e-3;
  Aiming aiming(config);
  auto& [device, loop] = aiming;
  for (int i = 0; i < 800; ++i) {
    const core::VecQ q = loop.tick().sample.q;
    EXPECT_NEAR(std::remainder(q[0], 5e-5), 0.0, 1e-15);
    EXPECT_NEAR(std::remainder(q[1], 2e-3), 0.0, 1e-13);
    EXPECT_LE(std::abs(q[0] - device.fingers()[0].q()[0]), 2.6e-5);
  }
}

TEST(HandIntent, ARecordingRepeatsWithoutJump) {
  const test::TemporaryFile file(
      "time_s,q_o1_mcp_rad,q_o2_pip_rad\n0,0.1,0.2\n0.5,0.9,0.3\n1.0,0.6,0.9\n");
  const HandIntent intent({.fingers = {{}}}, core::VecQ::Zero(2), *test::one_finger(), file.path());
  core::VecQ last = intent.at(0.0);
  EXPECT_EQ(last, core::VecQ::Zero(2));
  for (double t = 0.0; t < 10.0; t += 0.001) {
    EXPECT_LT((intent.at(t) - last).norm(), 0.01) << t;
    last = intent.at(t);
  }
  // 1 s of recording and 0.5 s of return make a round: its rows come back every 1.5 s.
  for (int round = 1; round < 5; ++round) {
    EXPECT_NEAR(intent.at(1.5 * round + 0.5)[0], 0.9, 1e-9);
    EXPECT_NEAR(intent.at(1.5 * round + 0.5)[1], 0.3, 1e-9);
    EXPECT_NEAR(intent.at(1.5 * round + 1.0)[1], 0.9, 1e-9);
  }
}

TEST(SimulatedFinger, DescribesItself) {
  const SimulatedHand device(aiming_at(0.0, 0.0), test::one_finger());
  const DeviceInfo& info = device.info();
  EXPECT_EQ(info.kind, "simulated");
  EXPECT_TRUE(info.moves);
  EXPECT_EQ(info.limits.sample_period, 1ms);
  EXPECT_EQ(info.limits.max_silence, 10ms);
  EXPECT_EQ(info.limits.silence_policy, core::SilencePolicy::kFault);
  ASSERT_EQ(info.limits.max_effort.size(), 1);
  EXPECT_EQ(info.limits.max_effort[0], 40.0);
  // Stroke 0..50 mm and 5 % of its span.
  EXPECT_NEAR(info.limits.q_lower[0], -0.0025, 1e-15);
  EXPECT_NEAR(info.limits.q_upper[0], 0.0525, 1e-15);
}

}  // namespace
}  // namespace haptic::hw
