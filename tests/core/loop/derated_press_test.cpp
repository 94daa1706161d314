// Presses with a held proxy behind a network, with the stiffness in effect
// (core/METHOD.md#stiffness-in-effect), on the real pipeline in virtual time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/core/loop/rail_press.hpp"

namespace haptic::core::press {
namespace {

PipelineConfig config(bool derating) {
  PipelineConfig c = patient_rail();
  c.derating = derating;
  return c;
}

/// The surface that it sends as planes without ids, while it sees contact.
ClientSettings derived_planes(double round_trip_s) {
  ClientSettings settings = wall_client(round_trip_s, ProxyMode::kPlanes, 0.0);
  settings.told_rigid = settings.only_in_contact = true;
  return settings;
}

struct DeratedFigures : Figures {
  double stiffness{Rails::coupling};  ///< least in effect, N/m
};

/// From the second push on, against the wall itself with the stiffness in effect. With a tank that
/// begins as PassivitySettings has it, or without.
DeratedFigures in_and_out(const ClientSettings& client, bool derating, bool tank) {
  DeratedFigures f;
  Press press{.pipeline = config(derating), .client = client, .judged_from = 1.429};
  press.pipeline.passivity.tank.enabled = tank;
  const auto in_effect = [](const TickRecord& record) {
    const VecA& derated = record.derating.stiffness;
    return derated.size() > 0 ? derated[0] : Rails::coupling;
  };
  press.shadow = [&](const TickRecord& record) {
    return -in_effect(record) * std::max(0.0, record.sensed.q[0]) / (1.0 + client.compliance);
  };
  press.observe = [&](const TickRecord& record) {
    f.stiffness = std::min(f.stiffness, in_effect(record));
  };
  static_cast<Figures&>(f) = felt(press);
  return f;
}

TEST(DeratedPress, HeldProxyGivesNoEnergy) {
  for (const double round_trip : {0.050, 0.100}) {
    SCOPED_TRACE(std::to_string(round_trip));
    const ClientSettings held = wall_client(round_trip, ProxyMode::kHeld);
    const DeratedFigures whole = in_and_out(held, false, false);
    const DeratedFigures derated = in_and_out(held, true, false);
    EXPECT_GT(whole.given, 0.05);
    EXPECT_LT(derated.given, 1e-6);
    EXPECT_LT(derated.drag, 0.2 * whole.drag);
  }
}

TEST(DeratedPress, TankHoldsBackLess) {
  for (const double round_trip : {0.050, 0.100}) {
    SCOPED_TRACE(std::to_string(round_trip));
    for (const ClientSettings& sent :
         {wall_client(round_trip, ProxyMode::kHeld), derived_planes(round_trip)}) {
      const DeratedFigures whole = in_and_out(sent, false, true);
      const DeratedFigures derated = in_and_out(sent, true, true);
      EXPECT_LE(derated.given, 1e-6);
      EXPECT_LT(derated.held_back, 0.7 * whole.held_back);
      EXPECT_LT(derated.percent(), 1.25 * whole.percent());
    }
  }
}

TEST(DeratedPress, ContactsKeepTheirStiffness) {
  for (const double round_trip : {0.0, 0.100, 0.200}) {
    SCOPED_TRACE(std::to_string(round_trip));
    EXPECT_EQ(in_and_out(wall_client(round_trip), true, true).stiffness, Rails::coupling);
  }
  EXPECT_EQ(in_and_out(wall_client(0.0, ProxyMode::kHeld), true, true).stiffness, Rails::coupling);
}

/// The device is led to and fro in free space, where a held proxy that is not quite the probe is
/// late all the way.
TEST(DeratedPress, AnyHandsDampingPaysForIt) {
  for (const double round_trip : {0.010, 0.020, 0.050, 0.100}) {
    for (const double jitter : {0.0, 0.3}) {
      ClientSettings late = wall_client(round_trip, ProxyMode::kHeld);
      late.simulate = [](haptic::test::Frame& frame) { frame.x = frame.x_probe.array() + 2e-6; };
      late.jitter = jitter;
      for (double hz = 1.0; hz < 60.0; hz *= 1.07) {
        // The device's damping, and twice as much of the hand.
        haptic::test::PipelineLoop loop(config(true), late, 3.0 * Rails::damping);
        double largest = 0.0, net = 0.0;
        for (int k = 1; k <= 6000; ++k) {
          const double t = 1e-3 * k;
          if (k == 1000) loop.engage();
          static_cast<void>(loop.tick(VecQ::Constant(1, 0.01 * std::sin(2.0 * M_PI * hz * t))));
          if (k == 2000) loop.energy().begin_cycle();
          if (k <= 2000) continue;
          net = loop.energy().net();
          largest = std::max(largest, std::abs(loop.energy().given()));
        }
        ASSERT_LE(net, 1e-3 * largest) << round_trip << " s, " << jitter << ", " << hz << " Hz";
      }
    }
  }
}

}  // namespace
}  // namespace haptic::core::press
