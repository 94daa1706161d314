// Contacts in the tick, on the real pipeline in virtual time (core/METHOD.md#contacts): a hand
// moves a mass in and out of a soft object whose simulation is behind a network.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "haptic/client/estimator.hpp"
#include "tests/support/loop/pipeline_loop.hpp"
#include "tests/support/loop/rails.hpp"
#include "tests/support/plane_set.hpp"

namespace haptic::core {
namespace {

using haptic::test::ClientSettings;
using haptic::test::PipelineLoop;
using haptic::test::Rails;

constexpr double kCoupling = Rails::coupling, kObject = 500.0;  // N/m
constexpr double kGamma = kCoupling / kObject;
constexpr double kLight = 0.018, kHard = 0.0353;  // m of the hand: 4.6 and 9 N

struct SoftRun {
  ClientSettings client{};
  double amplitude{kLight};  ///< of the hand about the surface, m
  double frequency{0.7};     ///< Hz
  double tank{-1.0};         ///< tank_0, J; < 0: no tank
};

struct SoftFigures {
  double rms_error{0.0};           ///< force felt less the shadow's, in contact, N
  double peak{0.0};                ///< of the shadow's force, N
  double held_back{0.0};           ///< share of the ticks in contact in which the tank acted
  double most_net{0.0};            ///< J
  double drag{0.0};                ///< largest force outside the object, N
  double tank{0.0}, storage{0.0};  ///< largest, J
};

/// A simulation of the soft object that tells it as a contact, always.
ClientSettings contacts_client(double round_trip_s) {
  ClientSettings client;
  client.mode = ProxyMode::kPlanes;
  client.stop = VecX::Zero(1);
  client.compliance = kGamma;
  client.delay_s = round_trip_s;
  return client;
}

SoftFigures felt(const SoftRun& what) {
  constexpr int kBegin = 1000, kTicks = kBegin + 8000;
  PipelineLoop loop(haptic::test::patient_rail(what.tank), what.client, Rails::damping);
  haptic::test::HandMasses mass(haptic::test::swinging(what.frequency, what.amplitude));
  SoftFigures f;
  double squares = 0.0;
  int contact = 0, held_back = 0;
  for (int k = 1; k <= kTicks; ++k) {
    mass.step((k - kBegin) * 1e-3, loop.tau_a());
    const double q = mass.q()[0];
    if (k == kBegin - 400) loop.engage();
    const TickRecord& record = loop.tick(mass.q());
    if (k < kBegin) continue;
    const double shadow = q > 0.0 ? -kCoupling * q / (1.0 + kGamma) : 0.0;
    f.peak = std::max(f.peak, -shadow);
    f.tank = std::max(f.tank, record.effort.passivity.tank);
    f.storage = std::max(f.storage, record.effort.passivity.storage);
    if (q <= 0.0) {
      f.drag = std::max(f.drag, std::abs(loop.tau()));
      continue;
    }
    ++contact;
    squares += (loop.tau() - shadow) * (loop.tau() - shadow);
    held_back += record.limiters().has(Limiter::kEnergyTank) ? 1 : 0;
  }
  loop.require_engaged();
  f.rms_error = std::sqrt(squares / std::max(contact, 1));
  f.held_back = static_cast<double>(held_back) / std::max(contact, 1);
  f.most_net = loop.energy().most_net();
  return f;
}

TEST(Contacts, DelayIsNotFelt) {
  for (const double round_trip : {0.0, 0.020, 0.050, 0.100}) {
    for (const double frequency : {0.7, 2.0}) {
      SCOPED_TRACE(std::to_string(round_trip) + " s, " + std::to_string(frequency) + " Hz");
      SoftRun run{.client = contacts_client(round_trip), .frequency = frequency};
      const SoftFigures contacts = felt(run);
      EXPECT_GT(contacts.peak, 3.0);
      EXPECT_LT(contacts.rms_error, 1e-6);
      EXPECT_EQ(contacts.drag, 0.0);
      EXPECT_LE(contacts.most_net, 1e-9);
      // The peers of the table: rigid planes, told before touch and while the client sees contact.
      run.client.told_rigid = true;
      const SoftFigures planes = felt(run);
      run.client.only_in_contact = true;
      const SoftFigures derived = felt(run);
      EXPECT_GT(planes.rms_error, 0.2);
      EXPECT_GT(derived.rms_error, 0.2);
    }
  }
}

TEST(Contacts, RightLawIsNeverHeldBack) {
  for (const double round_trip : {0.0, 0.050, 0.100}) {
    SCOPED_TRACE(std::to_string(round_trip));
    const SoftFigures f =
        felt({.client = contacts_client(round_trip), .amplitude = kHard, .tank = 0.0});
    EXPECT_GT(f.peak, 8.9);
    EXPECT_EQ(f.held_back, 0.0);
    EXPECT_LT(f.rms_error, 1e-6);
    EXPECT_LE(f.most_net, 1e-9);
    // Coupling and object at 9 N: 27 + 81 mJ; beside them the tank keeps within its capacity.
    EXPECT_NEAR(f.storage, 0.5 * f.peak * f.peak * (1 / kCoupling + 1 / kObject), 1e-3);
    EXPECT_LE(f.tank, 0.05);
  }
}

TEST(Contacts, TankBoundsAWrongLaw) {
  for (const double wrong : {0.1, 0.5, 2.0, 10.0}) {
    for (const double round_trip : {0.020, 0.100}) {
      SCOPED_TRACE(std::to_string(wrong) + ", " + std::to_string(round_trip));
      SoftRun run{.client = contacts_client(round_trip), .amplitude = kHard, .tank = 2e-3};
      run.client.told_compliance = wrong * kGamma;
      EXPECT_LE(felt(run).most_net, 2e-3 + 1e-9);
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
  ClientSettings settings = contacts_client(round_trip_s);
  settings.compliance = 0.0;
  settings.stop[0] = std::numeric_limits<double>::infinity();  // nothing is told unless it touches
  settings.simulate = [=, client = std::make_shared<Client>()](test::Frame& frame) {
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
    frame.walls = test::plane_set(contacts, 1);
  };
  return settings;
}

TEST(Contacts, EstimatedBeatsARigidPlane) {
  for (const double lag : {0.0, 0.020}) {
    for (const double round_trip : {0.0, 0.020, 0.050, 0.100}) {
      SCOPED_TRACE(std::to_string(lag) + " s, " + std::to_string(round_trip) + " s");
      const SoftFigures planes = felt({.client = proxies_client(round_trip, lag, false)});
      const SoftFigures estimated = felt({.client = proxies_client(round_trip, lag, true)});
      EXPECT_LT(estimated.rms_error, (lag > 0.0 ? 0.9 : 0.4) * planes.rms_error);
      EXPECT_LE(estimated.most_net, planes.most_net + 1e-3);
      const double most = lag > 0.0 || round_trip > 0.050 ? 0.4 : 0.1;
      EXPECT_LE(estimated.rms_error, most * estimated.peak);
    }
  }
}

TEST(Contacts, SurfaceMovesForTheSamplesAge) {
  using std::chrono::milliseconds;
  Pipeline pipeline(haptic::test::patient_rail());
  TickInput in;
  in.settings = pipeline.config().scene;
  in.device.fresh = in.device.armed = true;
  in.device.sample.q = VecQ::Constant(1, 0.15);
  in.command.tenure = 1;
  in.command.lease_held = true;
  in.proxy.mode = ProxyMode::kPlanes;
  in.proxy.tenure = 1;
  in.proxy.seq = 1;
  in.proxy.born = TimePoint(milliseconds(1));
  in.proxy.x = VecX::Zero(1);
  in.proxy.planes.normals = MatXQ::Identity(1, 1);
  in.proxy.planes.offsets = VecX::Zero(1);
  in.proxy.planes.velocity = VecX::Constant(1, 0.1);
  for (int k = 1; k <= 450; ++k) {
    in.now = in.device.sample.time = TimePoint(milliseconds(k));
    in.device.sample.seq = static_cast<std::uint64_t>(k);
    const double age = 1e-3 * std::min(k - 1, 400);  // hold_end
    ASSERT_NEAR(pipeline.tick(in).anchor.x[0], 0.1 * age, 1e-12) << k;
  }
  // Counted from the source's time where it is known, which is up to hold_end before the arrival.
  const TimePoint now = in.now;
  for (const auto& [computed, age] : {std::pair{now - milliseconds(120), 0.120},
                                      {TimePoint(Duration(1)), 0.42},
                                      {now + std::chrono::hours(1), 0.02}}) {
    ++in.proxy.seq;
    in.proxy.born = now - milliseconds(20);
    in.proxy.computed = computed;
    EXPECT_NEAR(pipeline.tick(in).anchor.x[0], 0.1 * age, 1e-12);
  }
}

TEST(Contacts, AnchorHalvesAWrongCompliance) {
  SoftRun run{.client = contacts_client(0.050)};
  run.client.told_compliance = 2.0 * kGamma;
  const double anchored = felt(run).rms_error;
  run.client.anchored = false;
  EXPECT_LT(anchored, 0.5 * felt(run).rms_error);
}

}  // namespace
}  // namespace haptic::core
