#include "haptic/core/passivity/passivity_observer.hpp"

#include <gtest/gtest.h>

#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

constexpr double T = 1e-3, K = 1000.0;

ObserverSettings settings() {
  ObserverSettings s;
  s.enabled = true;
  s.inertia = one(1.0);
  return s;
}

SpringStorage diagonal(double stiffness) {
  return {.stiffness = one(stiffness)};
}

/// Work of a held spring over a move of dq: the hold's leak, and the controller's own part.
HoldAccount held(double dq, double tau_controller) {
  HoldAccount account;
  account.leak = 0.5 * K * dq * dq;
  account.rendered = -tau_controller * dq;
  return account;
}

TEST(PassivityObserver, HeldSpringGetsHalfPeriodDamping) {
  PassivityObserver observer(settings(), 1);
  constexpr double dq = 1e-4;
  double tau = 0.0;
  for (int k = 0; k < 50; ++k) {
    observer.observe(held(dq, tau), one(dq), T, diagonal(K));
    tau = observer.tau()[0];
    // alpha K = K T / 2: what core/METHOD.md#sampled-data asks of a device's damping.
    ASSERT_NEAR(observer.alpha(), T / 2, 1e-12);
    ASSERT_NEAR(tau, -0.5 * K * T * dq / T, 1e-12);
  }
}

TEST(PassivityObserver, DampedDeviceGetsNoExtraDamping) {
  PassivityObserver observer(settings(), 1);
  for (int k = 0; k < 50; ++k) {
    HoldAccount account = held(1e-4, 0.0);
    account.device_damping = 1.01 * account.leak;
    observer.observe(account, one(1e-4), T, diagonal(K));
    ASSERT_EQ(observer.alpha(), 0.0);
    ASSERT_EQ(observer.tau()[0], 0.0);
  }
}

TEST(PassivityObserver, TheDevicesInertiaBoundsTheDamping) {
  ObserverSettings s = settings();
  s.inertia = one(0.05);
  PassivityObserver observer(s, 1);
  HoldAccount account;
  account.limits = -1.0;
  observer.observe(account, one(1e-4), T, diagonal(K));
  // alpha K / m <= 1 / (2 T), core/METHOD.md#passivity-observer.
  EXPECT_NEAR(observer.alpha() * K / 0.05, 1.0 / (2.0 * T), 1e-9);
}

TEST(PassivityObserver, AllowanceAndSlowestHoldItBack) {
  ObserverSettings s = settings();
  s.allowance = 1e-3;
  s.slowest = one(0.01);
  PassivityObserver observer(s, 1);
  HoldAccount account;
  account.limits = -0.9e-3;
  observer.observe(account, one(1e-4), T, diagonal(K));
  EXPECT_EQ(observer.alpha(), 0.0) << "within the allowance";
  observer.observe(account, one(0.9e-5), T, diagonal(K));
  EXPECT_EQ(observer.alpha(), 0.0) << "slower than the rate is known";
  observer.observe({}, one(1.1e-5), T, diagonal(K));
  EXPECT_GT(observer.alpha(), 0.0);
}

TEST(PassivityObserver, CreditBeyondTheForgettingIsDropped) {
  PassivityObserver observer(settings(), 1);
  HoldAccount account;
  account.limits = 1.0;
  observer.observe(account, one(1e-4), T, diagonal(K));
  EXPECT_EQ(observer.energy(), 0.5e-3);
  account.limits = -0.6e-3;
  observer.observe(account, one(1e-4), T, diagonal(K));
  EXPECT_GT(observer.alpha(), 0.0) << "what was dissipated long ago must not hide this";
}

TEST(PassivityObserver, RestartForgetsTheBook) {
  PassivityObserver observer(settings(), 1);
  HoldAccount account;
  account.limits = -1e-3;
  observer.observe(account, one(1e-4), T, diagonal(K));
  ASSERT_NE(observer.tau()[0], 0.0);
  observer.release();
  EXPECT_EQ(observer.tau()[0], 0.0);
  EXPECT_EQ(observer.energy(), -1e-3);
  observer.restart();
  EXPECT_EQ(observer.energy(), 0.0);
}

TEST(PassivityObserver, NeverDividesByZero) {
  PassivityObserver observer(settings(), 1);
  HoldAccount account;
  account.limits = -1e-3;
  observer.observe(account, one(0.0), T, diagonal(K));
  EXPECT_EQ(observer.alpha(), 0.0);
  observer.observe(account, one(1e-4), T, diagonal(0.0));
  EXPECT_EQ(observer.alpha(), 0.0);
}

}  // namespace
}  // namespace haptic::core
