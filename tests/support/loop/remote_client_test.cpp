#include "tests/support/loop/remote_client.hpp"

#include <gtest/gtest.h>

namespace haptic::test {
namespace {

using core::ProxyMode;
using core::ProxySnapshot;
using core::VecX;

ClientSettings every_tick() {
  return {.stop = VecX::Constant(1, 1e9), .rate_hz = 1000.0, .jitter = 0.0};
}

/// The probe's position is the time, so a sample tells when it was computed.
struct Stream {
  explicit Stream(const ClientSettings& settings) : client(settings) {}
  void tick() {
    t = ++k * 1e-3;
    const VecX x = VecX::Constant(1, t);
    client.step(t, core::TimePoint(std::chrono::milliseconds(k)), x, x, proxy);
  }
  RemoteClient client;
  ProxySnapshot proxy{};
  int k{0};
  double t{0.0};
};

TEST(RemoteClient, SampleArrivesAfterItsDelay) {
  ClientSettings settings = every_tick();
  settings.delay_s = 0.020;
  Stream run(settings);
  for (int i = 0; i < 20; ++i) run.tick();
  EXPECT_EQ(run.proxy.mode, ProxyMode::kNone);
  for (int i = 0; i < 200; ++i) {
    run.tick();
    ASSERT_EQ(run.proxy.mode, ProxyMode::kHeld);
    ASSERT_NEAR(run.proxy.x[0], run.t - 0.020, 1e-9);
  }
  EXPECT_EQ(run.proxy.gapless_samples, 200u);
}

TEST(RemoteClient, OlderSampleNeverReplacesANewer) {
  ClientSettings settings = every_tick();
  settings.rate_hz = 200.0;
  settings.delay_s = 0.010;
  settings.disorder = true;
  settings.lost = 0.5;
  Stream run(settings);
  double last = 0.0;
  for (int i = 0; i < 10000; ++i) {
    run.tick();
    if (run.proxy.seq == 0) continue;
    ASSERT_GE(run.proxy.x[0], last);
    last = run.proxy.x[0];
  }
  // 2000 looks, half of them lost, some overtaken by later ones.
  EXPECT_GT(run.proxy.gapless_samples, 400u);
  EXPECT_LT(run.proxy.gapless_samples, 1050u);
}

}  // namespace
}  // namespace haptic::test
