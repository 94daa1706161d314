#include "tests/support/loop/remote_client.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/vectors.hpp"

namespace haptic::test {
namespace {

using core::ProxyMode;
using core::ProxySnapshot;
using core::VecX;

ClientSettings every_tick() {
  ClientSettings settings;
  settings.stop = VecX::Constant(1, 1e9);
  settings.rate_hz = 1000.0;
  settings.jitter = 0.0;
  return settings;
}

/// The probe is where the clock is: a sample tells when it was computed.
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

TEST(RemoteClient, ASampleArrivesItsDelayAfterTheLook) {
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

TEST(RemoteClient, AnOlderSampleNeverReplacesANewerAndLostOnesNeverCome) {
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

TEST(RemoteClient, PlanesAreTheStopsOrThoseInContact) {
  ClientSettings settings = every_tick();
  settings.mode = ProxyMode::kPlanes;
  settings.stop = two(0.3, 0.4);
  ProxySnapshot proxy;
  const VecX x = two(0.2, 0.5);
  RemoteClient(settings).step(0.001, {}, x, x, proxy);
  EXPECT_EQ(proxy.planes.normals, core::MatXQ::Identity(2, 2));
  EXPECT_EQ(proxy.planes.offsets, two(0.3, 0.4));
  EXPECT_EQ(proxy.x, two(0.2, 0.4));
  settings.only_in_contact = true;
  RemoteClient(settings).step(0.001, {}, x, x, proxy);
  ASSERT_EQ(proxy.planes.size(), 1);
  EXPECT_EQ(VecX(proxy.planes.normals.col(0)), two(0.0, 1.0));
  EXPECT_EQ(proxy.planes.offsets[0], 0.4);
  settings.stop = two(std::numeric_limits<double>::infinity(), 0.6);
  RemoteClient(settings).step(0.001, {}, x, x, proxy);
  EXPECT_EQ(proxy.planes.size(), 0);
}

}  // namespace
}  // namespace haptic::test
