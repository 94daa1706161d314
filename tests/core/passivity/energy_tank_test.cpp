#include "haptic/core/passivity/energy_tank.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "haptic/core/passivity/passivity.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

using std::chrono::milliseconds;

SpringStorage spring(double stiffness, double gain = 1.0, double limit = 1e9) {
  return {one(stiffness), one(limit), gain};
}

TankSettings tank_of(double initial, double power = 0.0) {
  TankSettings s;
  s.enabled = true;
  s.initial = initial;
  s.allowed_power = power;
  return s;
}

TEST(EnergyTank, PaysFromAndRefillsItsLevel) {
  EnergyTank tank(tank_of(0.010));
  // 1000 N/m at 4 mm: 8 mJ.
  EXPECT_EQ(tank.admit(0.0, spring(1000.0), one(0.004)), 1.0);
  EXPECT_NEAR(tank.level(), 0.002, 1e-15);
  EXPECT_EQ(tank.admit(0.008, spring(1000.0), one(0.002)), 1.0);
  EXPECT_NEAR(tank.level(), 0.008, 1e-15);
}

TEST(EnergyTank, ShortensByTheDocumentedFactor) {
  EnergyTank tank(tank_of(0.001));
  // V_old 2 mJ, V_new 8 mJ: s = sqrt((2 + 1) / 8).
  EXPECT_NEAR(tank.admit(0.002, spring(1000.0), one(0.004)), std::sqrt(3.0 / 8.0), 1e-15);
  EXPECT_EQ(tank.level(), 0.0);
}

TEST(EnergyTank, ContactsHoldBesideTheCapacity) {
  EnergyTank tank(tank_of(0.0));  // of 50 mJ
  const SpringStorage none = spring(1000.0);
  // 200 mJ were put in; the spring needs 8, the contacts say 120.
  EXPECT_EQ(tank.admit(0.2, none, one(0.004), nullptr, 0.12), 1.0);
  EXPECT_NEAR(tank.contacts(), 0.12, 1e-15);
  EXPECT_NEAR(tank.level(), 0.05, 1e-15);
  // On the way out they give it back to the spring, and what they lost to the tank.
  EXPECT_EQ(tank.admit(0.0, none, one(0.016), nullptr, 0.01), 1.0);
  EXPECT_NEAR(tank.contacts() + tank.level(), 0.17 - 0.128, 1e-15);
  EXPECT_NEAR(tank.contacts(), 0.01, 1e-15);
}

TEST(EnergyTank, ContactsBringNoEnergy) {
  EnergyTank tank(tank_of(0.001));
  // A contact that appears with the finger deep inside says that it stores 1 J.
  EXPECT_NEAR(tank.admit(0.002, spring(1000.0), one(0.004), nullptr, 1.0), std::sqrt(3.0 / 8.0),
              1e-15);
  EXPECT_EQ(tank.contacts(), 0.0);
  EXPECT_EQ(tank.level(), 0.0);
}

/// Any client's way to choose an anchor: at once or held between late samples, in contacts that
/// come and go.
struct AnyClient {
  std::mt19937_64& random;
  int every;  ///< ticks between its samples
  double wall{0.0}, held{0.0};
  double at(int tick, double q) {
    std::normal_distribution<double> normal;
    wall += 2e-5 * normal(random);  // it pays for nothing
    if (tick % 400 == 0) wall = q - 0.003 * normal(random);
    if (tick % every == 0) held = tick % 700 < 350 ? wall : std::min(q, wall);
    return held;
  }
};

/// core/METHOD.md#energy-tank: for every force that is asked for, the energy given stays within
/// the tank's initial level and what a sudden motion surprises it with. Samples come late, the
/// sensor is noisy, contacts switch and limits act.
TEST(EnergyTank, NeverGivesMoreThanItHeld) {
  std::mt19937_64 random(23);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int throttled = 0;
  for (int trial = 0; trial < 300; ++trial) {
    PassivitySettings settings;
    settings.tank = tank_of(0.002);
    settings.device_damping = one(2.0);
    settings.device_inertia = one(0.5);
    Passivity passivity(settings, 1);
    passivity.restart();
    const double limit = trial % 3 == 0 ? 5.0 : 40.0, slew = trial % 2 == 0 ? 2500.0 : 1e6;
    const double noise = trial % 4 == 0 ? 5e-6 : 0.0;
    const SpringStorage k = spring(500.0 + 1500.0 * unit(random), 1.0, limit);
    AnyClient client{random, 1 + static_cast<int>(40.0 * unit(random) * unit(random))};
    double q = 0.0, v = 0.0, tau = 0.0, given = 0.0, pull = 0.0;
    for (int n = 0; n < 2000; ++n) {
      const double way = 1e-3 * v;
      given += tau * way - 2.0 * way * way / 1e-3;
      q += way;
      pull += 0.02 * normal(random) - 0.01 * pull;  // a user who pushes to and fro
      v += 1e-3 * (20.0 * pull - 50.0 * v + tau) / 0.5;
      const double sensed = q + noise * normal(random);
      passivity.measure(one(sensed), true, true, milliseconds(1));
      const double in_use = passivity.admit(k, one(client.at(n, sensed)), 0.0, one(slew))[0];
      throttled += passivity.record().throttled ? 1 : 0;
      tau = std::clamp(k.force(one(in_use - sensed))[0], tau - 1e-3 * slew, tau + 1e-3 * slew);
      passivity.hold(one(tau), one(0.0));
      ASSERT_LE(given, 0.002 + 1e-6) << trial << " " << n;
    }
  }
  EXPECT_GT(throttled, 10000) << "these loops must have bitten";
}

TEST(EnergyTank, DebtIsPaidByTheSpring) {
  EnergyTank tank(tank_of(0.0));
  HoldAccount leak;
  leak.leak = 0.003;
  tank.refill(1e-3, leak);
  EXPECT_NEAR(tank.level(), -0.003, 1e-18);
  // 8 mJ stored and kept: 3 mJ of it pay, s = sqrt(5 / 8).
  EXPECT_NEAR(tank.admit(0.008, spring(1000.0), one(0.004)), std::sqrt(5.0 / 8.0), 1e-15);
  EXPECT_EQ(tank.level(), 0.0);
  tank.refill(1e-3, leak);
  EXPECT_EQ(tank.admit(0.002, spring(1000.0), one(0.004)), 0.0)
      << "all of it, and that is not enough";
  EXPECT_NEAR(tank.level(), -0.001, 1e-18);
  EXPECT_EQ(tank.admit(0.0, spring(1000.0), one(0.0)), 1.0) << "no spring: nothing is held back";
  EXPECT_NEAR(tank.level(), -0.001, 1e-18) << "the debt stays";
}

TEST(EnergyTank, DevicesDampingPaysTheLeakOnly) {
  EnergyTank tank(tank_of(0.001));
  HoldAccount account;
  account.leak = 0.002;
  account.device_damping = 0.005;
  tank.refill(1e-3, account);
  EXPECT_EQ(tank.level(), 0.001);
  account.device_damping = 0.0015;
  tank.refill(1e-3, account);
  EXPECT_NEAR(tank.level(), 0.0005, 1e-18);
  account = {};
  account.rendered = 0.002;
  account.limits = -0.001;
  tank.refill(1e-3, account);
  EXPECT_NEAR(tank.level(), 0.0015, 1e-18) << "rendered damping and limits as they were";
}

TEST(EnergyTank, FillsAtAllowedPowerToCapacity) {
  EnergyTank tank(tank_of(0.0, 2.0));
  tank.refill(0.010, {});
  EXPECT_NEAR(tank.level(), 0.020, 1e-16);
  tank.refill(1.0, {});
  EXPECT_EQ(tank.level(), 0.05);
  EXPECT_EQ(tank.admit(1.0, spring(1000.0), one(0.0)), 1.0);
  EXPECT_EQ(tank.level(), 0.05) << "what comes back does not overfill it either";
}

/// The law of core/METHOD.md#energy-tank over thousands of arbitrary ticks: random anchors,
/// stiffness, gain, motion, held forces that are not the law's. Work on the user, net of the
/// device's damping, never exceeds the tank.
TEST(Passivity, ReturnedEnergyNeverExceedsTheTank) {
  constexpr double kInitial = 0.004, kPower = 0.02, kDeviceDamping = 1.5, T = 1e-3;
  PassivitySettings settings;
  settings.tank = tank_of(kInitial, kPower);
  settings.device_damping = one(kDeviceDamping);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    Passivity passivity(settings, 1);
    double q = 0.0, held = 0.0, returned = 0.0, anchor = 0.0;
    double stiffness = 1000.0, gain = 0.0;
    int throttled = 0;
    for (int k = 0; k < 3000; ++k) {
      const double dq = k == 0 ? 0.0 : 4e-4 * (unit(random) - 0.5);
      q += dq;
      returned += held * dq - kDeviceDamping * dq * dq / T;
      passivity.measure(one(q), true, true, milliseconds(1));
      if (unit(random) < 0.05) anchor = q + 0.02 * (unit(random) - 0.5);
      if (unit(random) < 0.05) stiffness = 2000.0 * unit(random);
      if (unit(random) < 0.10) gain = unit(random);
      const SpringStorage law = spring(stiffness, gain, 5.0);
      const double used = passivity.admit(law, one(anchor))[0] - q;
      throttled += passivity.record().throttled ? 1 : 0;
      const double elastic = law.force(one(used))[0] + 0.5 * (unit(random) - 0.5);
      const double damping = -3.0 * dq / T;
      passivity.hold(one(elastic), one(damping));
      held = elastic + damping;
      const double allowed = kInitial + kPower * T * (k + 1);
      ASSERT_LE(returned + passivity.record().storage, allowed + 1e-12)
          << "seed " << seed << ", " << k;
    }
    EXPECT_GT(throttled, 10) << "this run must have bitten";
  }
}

TEST(Passivity, BooksRareSamplesOverAllTicks) {
  PassivitySettings settings;
  settings.tank = tank_of(0.0);
  settings.device_damping = one(2.0);
  Passivity passivity(settings, 1);
  passivity.measure(one(0.0), true, true, milliseconds(1));
  passivity.admit(spring(0.0), one(0.0));
  passivity.hold(one(0.0), one(-1.0));
  passivity.measure(one(0.0), false, true, milliseconds(1));
  EXPECT_EQ(passivity.record().hold.rendered, 0.0);
  passivity.hold(one(0.0), one(-3.0));
  passivity.measure(one(0.001), true, true, milliseconds(1));
  EXPECT_NEAR(passivity.record().hold.rendered, 2.0 * 0.001, 1e-15);
  EXPECT_NEAR(passivity.record().hold.device_damping, 2.0 * 1e-6 / 2e-3, 1e-15);
}

TEST(Passivity, NamesInconsistentSettings) {
  PassivitySettings settings;
  EXPECT_EQ(check(settings, 1), nullptr);
  settings.tank = tank_of(0.06);
  EXPECT_STREQ(check(settings, 1), "tank.initial must be in [0, capacity]");
  settings.tank = tank_of(0.0, -1.0);
  EXPECT_STREQ(check(settings, 1), "tank.allowed_power must be >= 0");
  settings.tank = tank_of(0.0);
  settings.device_damping = VecA::Constant(2, 1.0);
  EXPECT_NE(check(settings, 1), nullptr);
  settings.device_damping = one(1.0);
  EXPECT_EQ(check(settings, 1), nullptr);
  settings.observer.enabled = true;
  EXPECT_STREQ(check(settings, 1), "observer.inertia must have one value > 0 per actuated DoF");
}

}  // namespace
}  // namespace haptic::core
