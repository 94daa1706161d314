#include "tests/support/loop/remote_client.hpp"

#include <gtest/gtest.h>

namespace haptic::test {
namespace {

using core::ProxyMode;
using core::ProxySnapshot;
using core::VecX;

/// The probe's position is the time, so a sample tells when it was computed.
TEST(RemoteClient, SamplesAreLateAndInOrder) {
  for (const bool trouble : {false, true}) {
    RemoteClient client({.stop = VecX::Constant(1, 1e9),
                         .rate_hz = trouble ? 200.0 : 1000.0,
                         .delay_s = 0.020,
                         .jitter = 0.0,
                         .lost = trouble ? 0.5 : 0.0,
                         .disorder = trouble});
    ProxySnapshot proxy;
    double last = 0.0;
    for (int k = 1; k <= 10000; ++k) {
      const double t = k * 1e-3;
      const VecX x = VecX::Constant(1, t);
      client.step(t, core::TimePoint(std::chrono::milliseconds(k)), x, x, proxy);
      client.look_after(t, x, x);
      ASSERT_EQ(proxy.mode, proxy.seq > 0 ? ProxyMode::kHeld : ProxyMode::kNone);
      if (proxy.seq == 0) continue;
      ASSERT_GE(proxy.x[0], last);
      ASSERT_LE(proxy.x[0], t - 0.020 + 1e-9);
      ASSERT_GE(proxy.x[0], trouble ? 0.0 : t - 0.020 - 1e-9);
      last = proxy.x[0];
    }
    // Half of 2000 looks are lost, and some are overtaken by later ones.
    EXPECT_GT(proxy.gapless_samples, trouble ? 400u : 9970u);
    EXPECT_LT(proxy.gapless_samples, trouble ? 1050u : 9985u);
  }
}

TEST(RemoteClient, SeesWhatTheStateTells) {
  const VecX reading = VecX::Constant(1, 1.0), told = VecX::Constant(1, 2.0);
  for (const bool filtered : {false, true}) {
    RemoteClient client({.stop = VecX::Constant(1, 1e9), .rate_hz = 1000.0, .jitter = 0.0},
                        filtered);
    ProxySnapshot proxy;
    client.step(0.001, {}, reading, reading, proxy);
    client.look_after(0.001, told, told);
    ASSERT_EQ(proxy.seq, filtered ? 0u : 1u);
    client.step(0.002, {}, reading, reading, proxy);
    EXPECT_EQ(proxy.x, filtered ? told : reading);
    EXPECT_EQ(proxy.seen_at, filtered ? 1u : 2u);
  }
}

}  // namespace
}  // namespace haptic::test
