// Presses with a held proxy behind a network, with the stiffness in effect
// (core/METHOD.md#stiffness-in-effect), on the real pipeline in virtual time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/loop/pipeline_loop.hpp"
#include "tests/support/loop/rails.hpp"

namespace haptic::core::derated_press {
namespace {

using haptic::test::ClientSettings;
using haptic::test::PipelineLoop;

constexpr double kWhole = 1500.0, kObject = 500.0;   // N/m
constexpr double kMass = 0.3, kDamping = 2.0;        // of the device, kg, N s/m
constexpr double kHand = 800.0, kHandDamping = 8.0;  // N/m, N s/m
constexpr double kCompliance = kWhole / kObject;

PipelineConfig config(bool derating) {
  PipelineConfig c = haptic::test::patient_rail();
  c.derating = derating;
  return c;
}

/// A simulation of a soft or rigid wall at 0.
ClientSettings client(ProxyMode mode, double round_trip_s, double compliance = kCompliance) {
  ClientSettings client;
  client.mode = mode;
  client.stop = VecX::Zero(1);
  client.compliance = compliance;
  client.delay_s = round_trip_s;
  return client;
}

/// The surface that it sends as planes without ids, while it sees contact.
ClientSettings derived_planes(double round_trip_s, double compliance = kCompliance) {
  ClientSettings settings = client(ProxyMode::kPlanes, round_trip_s, compliance);
  settings.told_rigid = settings.only_in_contact = true;
  return settings;
}

struct Press {
  double given{0.0};  ///< J, most beyond the device's own damping
  double peak{0.0};   ///< of the force felt in contact, N
  double error{0.0};  ///< rms in contact against the wall itself with the stiffness in effect, N
  double ideal_peak{0.0};  ///< of that wall, N
  double drag{0.0};        ///< largest outside the object, N
  double held_back{0.0};   ///< share of the ticks in contact in which the tank acted
  double stiffness{0.0};   ///< least in effect, N/m
};

/// In and out of the wall by 18 mm at 0.7 Hz, from the second time on.
Press in_and_out(const ClientSettings& of, bool derating, bool tank) {
  constexpr int kSubsteps = 10, kBegin = 1000, kFrom = kBegin + 1429, kTicks = kBegin + 10000;
  constexpr double kAmplitude = 0.018, w = 2.0 * M_PI * 0.7, dt = 1e-3 / kSubsteps;
  PipelineConfig c = config(derating);
  c.passivity.tank.enabled = tank;
  PipelineLoop loop(c, of, kDamping);
  Press f{.stiffness = kWhole};
  double q = -kAmplitude, v = 0.0, squares = 0.0;
  int contact = 0, held_back = 0;
  for (int k = 1; k <= kTicks; ++k) {
    for (int s = 0; s < kSubsteps; ++s) {
      const double t = std::max(0.0, (k - kBegin) * 1e-3 + s * dt);
      const double push = kHand * (-kAmplitude * std::cos(w * t) - q) +
                          kHandDamping * (kAmplitude * w * std::sin(w * t) - v) + loop.tau();
      v = (v + dt * push / kMass) / (1.0 + dt * kDamping / kMass);
      q = std::clamp(q + dt * v, -0.9, 0.9);
    }
    if (k == kBegin - 400) loop.engage();
    const TickRecord& record = loop.tick(VecQ::Constant(1, q));
    const VecA& derated = record.derating.stiffness;
    const double K = derated.size() > 0 ? derated[0] : kWhole;
    f.stiffness = std::min(f.stiffness, K);
    if (k < kFrom) continue;
    if (q <= 0.0) {
      f.drag = std::max(f.drag, std::abs(loop.tau()));
      continue;
    }
    const double ideal = -K * q / (1.0 + of.compliance);
    squares += (loop.tau() - ideal) * (loop.tau() - ideal);
    f.peak = std::max(f.peak, -loop.tau());
    f.ideal_peak = std::max(f.ideal_peak, -ideal);
    held_back += record.limiters().has(Limiter::kEnergyTank) ? 1 : 0;
    ++contact;
  }
  loop.require_engaged();
  f.given = loop.energy().most_net();
  f.error = std::sqrt(squares / std::max(contact, 1));
  f.held_back = static_cast<double>(held_back) / std::max(contact, 1);
  return f;
}

TEST(DeratedPress, HeldProxyGivesNoEnergy) {
  for (const double round_trip : {0.050, 0.100}) {
    SCOPED_TRACE(std::to_string(round_trip));
    const ClientSettings held = client(ProxyMode::kHeld, round_trip);
    const Press whole = in_and_out(held, false, false), derated = in_and_out(held, true, false);
    EXPECT_GT(whole.given, 0.05);
    EXPECT_LT(derated.given, 1e-6);
    EXPECT_LT(derated.drag, 0.2 * whole.drag);
  }
}

TEST(DeratedPress, TankHoldsBackLess) {
  for (const double round_trip : {0.050, 0.100}) {
    SCOPED_TRACE(std::to_string(round_trip));
    for (const ClientSettings& sent :
         {client(ProxyMode::kHeld, round_trip), derived_planes(round_trip, 0.0)}) {
      const Press whole = in_and_out(sent, false, true), derated = in_and_out(sent, true, true);
      EXPECT_LE(derated.given, 1e-6);
      EXPECT_LT(derated.held_back, 0.7 * whole.held_back);
      EXPECT_LT(derated.error / derated.ideal_peak, 1.25 * whole.error / whole.ideal_peak);
    }
  }
}

TEST(DeratedPress, ContactsKeepTheirStiffness) {
  for (const double round_trip : {0.0, 0.100, 0.200}) {
    SCOPED_TRACE(std::to_string(round_trip));
    EXPECT_EQ(in_and_out(client(ProxyMode::kPlanes, round_trip), true, true).stiffness, kWhole);
  }
  EXPECT_EQ(in_and_out(client(ProxyMode::kHeld, 0.0), true, true).stiffness, kWhole);
}

/// The device is led to and fro in free space, where a held proxy that is not quite the probe is
/// late all the way.
TEST(DeratedPress, AnyHandsDampingPaysForIt) {
  for (const double round_trip : {0.010, 0.020, 0.050, 0.100}) {
    for (const double jitter : {0.0, 0.3}) {
      ClientSettings late = client(ProxyMode::kHeld, round_trip);
      late.simulate = [](haptic::test::Frame& frame) { frame.x = frame.x_probe.array() + 2e-6; };
      late.jitter = jitter;
      for (double hz = 1.0; hz < 60.0; hz *= 1.07) {
        // The device's damping, and twice as much of the hand.
        PipelineLoop loop(config(true), late, 3.0 * kDamping);
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
}  // namespace haptic::core::derated_press
