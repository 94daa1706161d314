// Contacts in the tick: a press on a soft wall behind a network (core/METHOD.md#contacts).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "haptic/client/estimator.hpp"
#include "tests/core/loop/rail_press.hpp"
#include "tests/core/tick/driven.hpp"
#include "tests/support/plane_set.hpp"

namespace haptic::core::press {
namespace {

TEST(Contacts, DelayIsNotFelt) {
  for (const double round_trip : {0.0, 0.020, 0.050, 0.100}) {
    for (const double frequency : {0.7, 2.0}) {
      SCOPED_TRACE(std::to_string(round_trip) + " s, " + std::to_string(frequency) + " Hz");
      Press press{.client = wall_client(round_trip), .frequency = frequency};
      const Figures contacts = felt(press);
      EXPECT_GT(contacts.peak, 3.0);
      EXPECT_LT(contacts.error, 1e-6);
      EXPECT_EQ(contacts.drag, 0.0);
      EXPECT_LE(contacts.given, 1e-9);
      // The peers of the table: rigid planes, told before touch and while the client sees contact.
      press.client.told_rigid = true;
      EXPECT_GT(felt(press).error, 0.2);
      press.client.only_in_contact = true;
      EXPECT_GT(felt(press).error, 0.2);
    }
  }
}

TEST(Contacts, RightLawIsNeverHeldBack) {
  for (const double round_trip : {0.0, 0.050, 0.100}) {
    SCOPED_TRACE(std::to_string(round_trip));
    double tank = 0.0, storage = 0.0;  // J, largest
    const Figures f = felt({.pipeline = patient_rail(0.0),
                            .client = wall_client(round_trip),
                            .amplitude = kHard,
                            .observe = [&](const TickRecord& record) {
                              tank = std::max(tank, record.effort.passivity.tank);
                              storage = std::max(storage, record.effort.passivity.storage);
                            }});
    EXPECT_GT(f.peak, 8.9);
    EXPECT_EQ(f.held_back, 0.0);
    EXPECT_LT(f.error, 1e-6);
    EXPECT_LE(f.given, 1e-9);
    // Coupling and object at 9 N: 27 + 81 mJ; beside them the tank keeps within its capacity.
    EXPECT_NEAR(storage, 0.5 * f.peak * f.peak * (1 / Rails::coupling + 1 / kObject), 1e-3);
    EXPECT_LE(tank, 0.05);
  }
}

TEST(Contacts, TankBoundsAWrongLaw) {
  for (const double wrong : {0.1, 0.5, 2.0, 10.0}) {
    for (const double round_trip : {0.020, 0.100}) {
      SCOPED_TRACE(std::to_string(wrong) + ", " + std::to_string(round_trip));
      Press press{
          .pipeline = patient_rail(2e-3), .client = wall_client(round_trip), .amplitude = kHard};
      press.client.told_compliance = wrong * kGamma;
      EXPECT_LE(felt(press).given, 2e-3 + 1e-9);
    }
  }
}

/// A simulation that only knows its proxy, with a solver that lags: what the client library derives
/// of it while it touches, rigid or with an estimated compliance.
ClientSettings proxies_client(double round_trip_s, double lag_s, bool estimated) {
  struct Client {
    client::ContactEstimator estimator{{{"x", "m", "linear"}}, {}};
    double x{0.0};  ///< m, of the sample before; 0: it touched nothing
  };
  ClientSettings settings = wall_client(round_trip_s, ProxyMode::kPlanes, 0.0);
  settings.stop[0] = std::numeric_limits<double>::infinity();  // nothing is told unless it touches
  settings.simulate = [=, client = std::make_shared<Client>()](haptic::test::Frame& frame) {
    const double probe = frame.x_probe[0];
    frame.x = frame.x_probe;
    frame.contact = probe > 0.0;
    frame.anchored = frame.contact && estimated;
    frame.walls = PlaneSet{};
    frame.walls.normals.resize(1, 0);
    if (!frame.contact) {
      client->x = 0.0;
      return client->estimator.free();
    }
    const double right = probe * kGamma / (1.0 + kGamma);
    const double before = client->x > 0.0 ? client->x : probe;
    const double rest = lag_s > 0.0 ? std::exp(-1.0 / (60.0 * lag_s)) : 0.0;
    client->x = frame.x[0] = std::min(right + rest * (before - right), probe);
    auto contacts = client->estimator.contacts({frame.x[0]}, {probe});
    if (!estimated) contacts = client::derive_planes({{"x", "m", "linear"}}, {frame.x[0]}, {probe});
    frame.walls = haptic::test::plane_set(contacts, 1);
  };
  return settings;
}

TEST(Contacts, EstimatedBeatsARigidPlane) {
  for (const double lag : {0.0, 0.020}) {
    for (const double round_trip : {0.0, 0.020, 0.050, 0.100}) {
      SCOPED_TRACE(std::to_string(lag) + " s, " + std::to_string(round_trip) + " s");
      const Figures planes = felt({.client = proxies_client(round_trip, lag, false)});
      const Figures estimated = felt({.client = proxies_client(round_trip, lag, true)});
      EXPECT_LT(estimated.error, (lag > 0.0 ? 0.9 : 0.4) * planes.error);
      EXPECT_LE(estimated.given, planes.given + 1e-3);
      const double most = lag > 0.0 || round_trip > 0.050 ? 0.4 : 0.1;
      EXPECT_LE(estimated.error, most * estimated.peak);
    }
  }
}

TEST(Contacts, SurfaceMovesForTheSamplesAge) {
  using std::chrono::milliseconds;
  core::test::DrivenPipeline loop(patient_rail());
  loop.input.device.sample.q = one(0.15);
  ProxySnapshot& proxy = loop.proxy;
  proxy.mode = ProxyMode::kPlanes;
  proxy.x = one(0.0);
  proxy.planes.normals = MatXQ::Identity(1, 1);
  proxy.planes.offsets = one(0.0);
  proxy.planes.velocity = one(0.1);
  for (int k = 1; k <= 450; ++k) {
    const double age = 1e-3 * std::min(k - 1, 400);  // hold_end
    ASSERT_NEAR(loop.tick(true, k == 1).anchor.x[0], 0.1 * age, 1e-12) << k;
  }
  // Counted from the source's time if it is known, which is up to hold_end before the arrival.
  for (const auto& [before, age] : {std::pair{milliseconds(120), 0.120},
                                    {milliseconds(10'000), 0.42},
                                    {milliseconds(-3'600'000), 0.02}}) {
    const TimePoint now = loop.input.now + milliseconds(1);
    ++proxy.seq;
    proxy.born = now - milliseconds(20);
    proxy.computed = now - before;
    EXPECT_NEAR(loop.tick(true, false).anchor.x[0], 0.1 * age, 1e-12);
  }
}

TEST(Contacts, AnchorHalvesAWrongCompliance) {
  Press press{.client = wall_client(0.050)};
  press.client.told_compliance = 2.0 * kGamma;
  const double anchored = felt(press).error;
  press.client.anchored = false;
  EXPECT_LT(anchored, 0.5 * felt(press).error);
}

}  // namespace
}  // namespace haptic::core::press
