/// The simulated hand: its fingers against a finger's physics alone, its palm, its sensors.
#include "hw/simulated/hand.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "haptic/core/model/hand_exoskeleton.hpp"
#include "tests/core/model/sample_hands.hpp"
#include "tests/hw/simulated/one_finger.hpp"
#include "tests/hw/virtual_loop.hpp"

namespace haptic::hw {
namespace {

using namespace std::chrono_literals;
using test::VirtualLoop;

std::shared_ptr<const core::Kinematics> five() {
  return core::make_hand_exoskeleton(core::five_fingers());
}

/// All joints at `angle` rad; a palm at 0.1, 0.05, 0.2 m, turned by 0.3, -0.2, 0.1 rad.
SimulatedHandConfig hand_aiming_at(double angle, bool on_a_palm = false) {
  SimulatedHandConfig config;
  config.fingers = 5;
  config.target = core::VecQ::Constant(on_a_palm ? 16 : 10, angle);
  if (on_a_palm) config.target.head<6>() << 0.1, 0.05, 0.2, 0.3, -0.2, 0.1;
  return config;
}

/// A device of its own in a loop; forces per finger.
struct Worn {
  Worn(const SimulatedHandConfig& config, std::shared_ptr<const core::Kinematics> kinematics)
      : device(config, std::move(kinematics)) {}
  SimulatedHand device;
  core::DeviceReading reading{};
  Command command{.tau_a = core::VecA::Zero(5)};
  core::TimePoint now{1s};

  void push(const core::VecA& tau_a) {
    command.arm = true;
    command.tau_a = tau_a;
  }
  const core::VecQ& tick() {
    device.read(now, reading);
    device.write(now, command);
    now += 1ms;
    return reading.sample.q;
  }
  const core::VecQ& run(int ticks) {
    for (int i = 0; i < ticks; ++i) tick();
    return reading.sample.q;
  }
};

core::VecA forces() {
  return (core::VecA(5) << -3.0, 2.0, -6.0, 0.0, -1.0).finished();
}

TEST(SimulatedHand, EachFingerMovesAsOneAlone) {
  // The same linkage, aim and force: the same bits, wherever the finger sits on the hand.
  for (const bool on_a_palm : {false, true}) {
    SimulatedHandConfig config = hand_aiming_at(0.5, on_a_palm);
    config.finger.actuator_friction = 0.4;
    Worn hand(config, on_a_palm ? test::hand_on_a_palm() : five());
    hand.push(forces());
    hand.run(900);
    for (int i = 0; i < 5; ++i) {
      const auto size = static_cast<std::size_t>(i);
      FingerPhysics alone(config.finger,
                          core::make_finger_exoskeleton(core::five_fingers()[size].dimensions),
                          Eigen::Vector2d::Zero());
      const HandIntent intent(core::VecQ::Zero(2), core::VecQ::Constant(2, 0.5));
      constexpr double kStep = core::seconds(SimulatedHand::kStep);
      for (int n = 1; n <= 899 * 5; ++n) {  // the force acts from the second tick on
        alone.step(kStep, intent.at(n * kStep), n <= 5 ? 0.0 : forces()[i]);
      }
      EXPECT_EQ(hand.device.fingers()[size].x(), alone.x()) << i;
      EXPECT_EQ(hand.reading.sample.q.segment<2>((on_a_palm ? 6 : 0) + 2 * i), alone.q()) << i;
    }
  }
}

TEST(SimulatedHand, StepsAreSmallEnough) {
  // Against a simulated finger in steps of half the size, where the force changes all the time.
  SimulatedHandConfig config = hand_aiming_at(0.8);
  Worn hand(config, five());
  SimulatedHandConfig alone;
  alone.target = core::VecQ::Constant(2, 0.8);
  SimulatedHand finger(alone, core::make_finger_exoskeleton(core::five_fingers()[1].dimensions));
  VirtualLoop loop(finger);
  double furthest = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double tau = 4.0 * std::sin(0.03 * i);
    hand.push(core::VecA::Constant(5, tau));
    loop.push(tau);
    furthest = std::max(furthest, std::abs(hand.tick()[2] - loop.tick().sample.q[0]));
  }
  EXPECT_LT(furthest, 2e-5);
}

TEST(SimulatedHand, ForcesLeaveThePalmAlone) {
  Worn pushed(hand_aiming_at(0.5, true), test::hand_on_a_palm()),
      free(hand_aiming_at(0.5, true), test::hand_on_a_palm());
  pushed.push(forces());
  for (int i = 0; i < 1000; ++i) {
    const core::VecQ q = pushed.tick();
    ASSERT_EQ(q.head<6>(), free.tick().head<6>()) << i;
  }
  EXPECT_LT((pushed.reading.sample.q.head<6>() - hand_aiming_at(0.5, true).target.head<6>()).norm(),
            1e-12);
  EXPECT_GT((pushed.reading.sample.q - free.reading.sample.q).norm(), 0.01);
}

TEST(SimulatedHand, ABadForceIsNoForce) {
  Worn hand(hand_aiming_at(0.5), five());
  hand.push(forces());
  hand.run(3);
  EXPECT_EQ(hand.device.tau_a(), forces());
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    core::VecA tau = forces();
    tau[1] = bad;
    tau[2] = -1e6;
    hand.push(tau);
    hand.tick();
    EXPECT_EQ(hand.device.tau_a()[0], -3.0);
    EXPECT_EQ(hand.device.tau_a()[1], 0.0);
    EXPECT_EQ(hand.device.tau_a()[2], -40.0);
  }
  hand.push(core::VecA::Constant(4, 1.0));
  hand.tick();
  EXPECT_EQ(hand.device.tau_a(), core::VecA::Zero(5));
  EXPECT_TRUE(hand.run(50).allFinite());
}

TEST(SimulatedHand, OnlyTheFingersSensorsAreNoisy) {
  SimulatedHandConfig config = hand_aiming_at(0.0, true);
  config.noise_l_x = 2e-5;
  config.noise_q_B = 3e-3;
  Worn hand(config, test::hand_on_a_palm()), again(config, test::hand_on_a_palm());
  config.seed = 2;
  Worn other(config, test::hand_on_a_palm());
  const core::VecQ truth = Worn(hand_aiming_at(0.0, true), test::hand_on_a_palm()).tick();
  core::VecQ square = core::VecQ::Zero(16);
  constexpr int kSamples = 4000;
  for (int i = 0; i < kSamples; ++i) {
    const core::VecQ q = hand.tick();
    ASSERT_EQ(q, again.tick());
    ASSERT_NE(q, other.tick());
    square += (q - truth).cwiseAbs2();
  }
  EXPECT_LT(square.head<6>().maxCoeff(), 1e-24);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(std::sqrt(square[6 + 2 * i] / kSamples), 2e-5, 2e-6);
    EXPECT_NEAR(std::sqrt(square[7 + 2 * i] / kSamples), 3e-3, 3e-4);
  }
}

}  // namespace
}  // namespace haptic::hw
