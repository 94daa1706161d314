// Loans of the energy tank (core/METHOD.md#energy-tank, Eq. (34)).
#include <gtest/gtest.h>

#include "haptic/core/passivity/passivity.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core::loans {
namespace {

using std::chrono::milliseconds;

SpringStorage lent_spring(double stiffness) {
  return {one(stiffness), one(1e9), 1.0};
}

TankSettings holding(double initial) {
  TankSettings s;
  s.enabled = true;
  s.initial = initial;
  return s;
}

/// A device that went `dq` in the last hold, as in the one before; its inertia is boundless.
Motion steady(double dq, double held) {
  return {one(dq), one(0.0), one(held), one(0.0), {}, one(0.0), {}, one(1e9), 1e-3};
}

TEST(Loan, TheNextHoldKeepsWithinIt) {
  EnergyTank tank(holding(0.001));
  const SpringStorage k = lent_spring(1000.0);
  // 8 mJ stored, 1 mJ there. At 4 N the next hold gives 4 N by 0.15 mm: 0.6 mJ.
  Motion motion = steady(1.5e-4, 4.0);
  EXPECT_EQ(tank.admit(0.0, k, one(0.004), &motion), 1.0);
  EXPECT_NEAR(tank.level(), -0.007, 1e-15);
  // It gave 0.5 mJ: what is left does not hold such a force once more.
  EXPECT_NEAR(tank.admit(0.0075, k, one(0.004), &motion), 5.0 / 6.0, 1e-12);
  // A force that takes has no bound of this kind.
  motion = steady(-1.5e-4, 4.0);
  EXPECT_EQ(motion.share(one(4.0), 1e-12), 1.0);
}

/// It keeps back what noise moves q_a by, so that the cap does not follow the noise.
TEST(Loan, SlowEndKeepsBackNoise) {
  Motion noisy = steady(0.0, 4.0);
  noisy.jitter = one(1e-5);
  EXPECT_EQ(noisy.share(one(4.0), 1.2e-4), 1.0);
  EXPECT_EQ(noisy.share(one(4.0), 2.4e-4 + 1e-9, true), 1.0) << "4 N by 6 jitters";
  EXPECT_NEAR(noisy.share(one(4.0), 1.2e-4, true), 0.5, 1e-12);
}

/// 50 g, sampled once per ms, led by a hand that holds 4 N: at rest it goes 4 N (1 ms)^2 / (2 50 g)
/// = 0.04 mm in the hold in which the hand lets go, and three times as far in the next one.
Motion of_50_g(double dq, double before) {
  return {one(dq), one(dq - before), one(4.0), one(1e-5), {}, one(0.0), {}, one(1e9), 1e-3};
}

TEST(Loan, AHandMayLetGo) {
  const VecA tau = one(4.0);
  const Motion rest = of_50_g(0.0, 0.0);
  EXPECT_NEAR(rest.share(tau, 0.00016), 1.0, 1e-12) << "4 N by 0.04 mm";
  EXPECT_NEAR(rest.share(tau, 0.00004), 0.5, 1e-12) << "2 N by 0.02 mm";
  const Motion flies = of_50_g(4e-5, 0.0);
  EXPECT_NEAR(flies.share(tau, 0.00048), 1.0, 1e-12) << "4 N by 0.12 mm";
  EXPECT_NEAR(flies.share(tau, 0.0002), 0.5, 1e-12) << "2 N by 0.1 mm";
  // Faster than the force itself makes it: a hand that pushes along, and may go on as it does.
  EXPECT_NEAR(of_50_g(4e-4, 0.0).share(tau, 4.0 * (4e-4 + 4e-5 + 4e-5)), 1.0, 1e-12);
  EXPECT_LT(of_50_g(4e-4, 0.0).share(tau, 3.9 * (4e-4 + 4e-5 + 4e-5)), 1.0);
  // A device that comes back takes that way first.
  EXPECT_NEAR(of_50_g(-4e-5, 0.0).share(tau, 0.00016), 1.0, 1e-12);
  EnergyTank none(holding(0.0));
  EXPECT_EQ(none.admit(0.0, lent_spring(1000.0), one(0.004), &rest), 0.0);
}

/// A hand that held 4 N lets go, and 50 g fly off with `left` in the tank.
double worst_debt(double left) {
  constexpr double kKick = 1e-5, kForce = 4.0;
  double dq = 0.0, before = 0.0, speed = 0.0, held = kForce, worst = 0.0;
  for (int n = 0; n < 40 && left > 0.0; ++n) {
    const Motion motion{one(dq), one(dq - before), one(held), one(kKick), {}};
    held = kForce * motion.share(one(kForce), left);
    before = dq;
    dq = speed + held * kKick;  // m per hold
    speed += 2.0 * held * kKick;
    left -= held * dq;
    worst = std::max(worst, -left);
  }
  return worst;
}

TEST(Loan, LettingGoMakesNoDebt) {
  for (double left = 1e-5; left < 3e-3; left += 1e-5) EXPECT_LE(worst_debt(left), 1e-15) << left;
}

/// 4 N that fall by 1 N per ms, along a motion of 0.1 mm per ms: (4 + 3 + 2 + 1) N by 0.1 mm.
TEST(Loan, ReckonsWithTheSlewLimit) {
  Motion motion = steady(1e-4, 4.0);
  motion.slew = one(1.0);
  EXPECT_LT(motion.share(one(4.0), 0.0010 - 1e-9), 1.0);
  EXPECT_EQ(motion.share(one(4.0), 0.0012 + 1e-9), 1.0) << "not much more";
  motion.dq = one(0.0);
  EXPECT_EQ(motion.share(one(4.0), 1e-9), 1.0) << "at rest nothing is given meanwhile";
}

/// The same from `force` (N) with just what letting go gives, through a limit of 4 N per ms. J.
double debt_through_slew(double force) {
  constexpr double kKick = 1e-5, kSlew = 4.0;
  const auto lent = [&](double dq, double before, double held, double left) {
    return Motion{one(dq), one(dq - before), one(held), one(kKick), one(kSlew)}.share(one(force),
                                                                                      left);
  };
  double sum = 0.0;
  for (double falls = force; falls > 0.0; falls -= kSlew) sum += falls;
  double left = kKick * sum * sum;  // what 50 g have after these holds
  EXPECT_NEAR(lent(0.0, 0.0, force, left), 1.0, 1e-12);
  EXPECT_LT(lent(0.0, 0.0, force, 0.99 * left), 1.0);
  double dq = 0.0, before = 0.0, speed = 0.0, tau = force, worst = 0.0;
  for (int n = 0; n < 40 && tau > 0.0; ++n) {
    const double wanted = left > 0.0 ? force * lent(dq, before, tau, left) : 0.0;
    tau = std::max(wanted, n == 0 ? 0.0 : tau - kSlew);
    before = dq;
    dq = speed + tau * kKick;
    speed += 2.0 * tau * kKick;
    left -= tau * dq;
    worst = std::max(worst, -left);
  }
  return worst;
}

TEST(Loan, LettingGoThroughSlewMakesNone) {
  for (const double force : {3.0, 4.0, 7.0, 13.0, 20.0}) {
    EXPECT_LE(debt_through_slew(force), 1e-12) << force;
  }
}

/// A hand leads the actuator along a force of 4 N at 20 mm/s: what is left runs out. The force ends
/// within milliseconds, but no faster than on a spring of M_a / T^2 = 50000 N/m.
TEST(Loan, EndsWithoutAJump) {
  const double step = 2e-5, most = 50000.0 * step;
  PassivitySettings settings;
  settings.tank = holding(0.004);
  settings.device_damping = one(25.0);  // as much as the hold of 50000 N/m leaks
  settings.device_inertia = one(0.05);
  Passivity passivity(settings, 1);
  passivity.restart();
  const SpringStorage k = lent_spring(1000.0);
  double q = 0.0, tau = 4.0, given = 0.0;
  passivity.measure(one(q), true, true, milliseconds(1));
  for (int n = 0; n < 400; ++n) {
    const double before = tau;
    tau = k.force(one(passivity.admit(k, one(q + 0.004))[0] - q))[0];
    passivity.hold(one(tau), one(0.0));
    ASSERT_LE(tau, std::max(before, 0.05)) << n;
    ASSERT_LE(before - tau, most) << n;
    given += tau * step - 25.0 * step * step / 1e-3;
    q += step;
    passivity.measure(one(q), true, true, milliseconds(1));
    ASSERT_LE(given, 0.004 + 1e-9) << n;
  }
  EXPECT_LT(tau, 0.05) << "it is gone";
  // The way back refills it, and the force returns as smoothly.
  for (int n = 0; n < 100; ++n) {
    const double before = tau;
    tau = k.force(one(passivity.admit(k, one(q + 0.004))[0] - q))[0];
    passivity.hold(one(tau), one(0.0));
    ASSERT_GE(tau, std::min(before, 0.0)) << n;
    ASSERT_LE(tau - before, most) << n;
    q -= step;
    passivity.measure(one(q), true, true, milliseconds(1));
  }
  EXPECT_GT(tau, 3.0);
}

/// The same with a force limit of 25 N: it fades by at most 0.125 N per ms, down and up, and gives
/// no more than the tank had. J, N/m, m/s.
void expect_a_fade(double initial, double stiffness, double speed) {
  PassivitySettings settings;
  settings.tank = holding(initial);
  settings.device_damping = one(2.0);
  settings.device_inertia = one(0.05);
  Passivity passivity(settings, 1);
  passivity.restart();
  const SpringStorage k{one(stiffness), one(25.0), 1.0};
  double q = 0.0, tau = 4.0, given = 0.0, weakest = 4.0;
  passivity.measure(one(q), true, true, milliseconds(1));
  for (int n = 0; n < 1000; ++n) {
    const double before = tau, way = 1e-3 * (n < 500 ? speed : -speed);
    tau = k.force(one(passivity.admit(k, one(q + 4.0 / stiffness))[0] - q))[0];
    passivity.hold(one(tau), one(0.0));
    ASSERT_LE(std::abs(tau - before), 0.125 + 1e-9) << n;
    weakest = std::min(weakest, tau);
    given += tau * way - 2.0 * way * way / 1e-3;
    q += way;
    passivity.measure(one(q), true, true, milliseconds(1));
    ASSERT_LE(given, initial + 1e-9) << n;
  }
  EXPECT_LT(weakest, 1.0) << "nothing had to fade";
  EXPECT_EQ(tau, 4.0) << "it is whole again";
}

TEST(Loan, FadesSlowly) {
  for (const double speed : {0.01, 0.02, 0.06}) expect_a_fade(0.012, 1500.0, speed);
  expect_a_fade(0.004, 500.0, 0.02);
}

}  // namespace
}  // namespace haptic::core::loans
