// Planes in the tick (core/METHOD.md#local-models; tests/report/STUDY.md#late-client and
// tests/report/STUDY.md#lost-and-repeated-samples).
#include <gtest/gtest.h>

#include <string>

#include "tests/core/tick/finger_bench.hpp"
#include "tests/support/loop/wall_run.hpp"

namespace haptic::core {
namespace {

using namespace test;
using haptic::test::wall_run;
using haptic::test::wall_tank;
using haptic::test::WallFigures;
using haptic::test::WallRun;

constexpr double kDelays[] = {0.0, 0.005, 0.010, 0.020, 0.050, 0.100};

WallRun in_and_out(ProxyMode mode, double delay) {
  WallRun run = wall_run(mode);
  run.client.delay_s = delay;
  return run;
}

TEST(Planes, WallNeitherGivesNorDrags) {
  for (const double stiffness : {500.0, 1500.0}) {
    for (const double delay : kDelays) {
      SCOPED_TRACE(std::to_string(delay));
      WallRun run = in_and_out(ProxyMode::kPlanes, delay);
      run.stiffness = stiffness;
      const WallFigures planes = haptic::test::run(run);
      EXPECT_GT(planes.peak_force, 3.0) << "the wall was felt";
      EXPECT_EQ(planes.drag, 0.0);
      EXPECT_LT(planes.most_net, 1e-9);  // case 22 asks for less than 2 mJ without the tank
      EXPECT_LT(planes.largest_q, 0.03);
    }
  }
}

TEST(Planes, HeldProxyDragsAsDocumented) {
  // K v (delay + half a period), 4 x 20 mm/s mean speed of the hand: what planes are for.
  WallRun run = in_and_out(ProxyMode::kHeld, 0.020);
  run.stiffness = 200.0;
  // Never quite the probe: a proxy that is goes on with it.
  run.client.simulate = [](haptic::test::Frame& frame) {
    frame.x = frame.x_probe.cwiseMin(0.0).array() + 2e-6;
  };
  const WallFigures held = haptic::test::run(run);
  EXPECT_GT(held.drag, 0.2);
  run.client.simulate = nullptr;
  run.client.mode = ProxyMode::kPlanes;
  EXPECT_LE(haptic::test::run(run).drag, 0.01 * held.drag);
}

TEST(Planes, EchoOfTheProbeIsFree) {
  for (const double delay : kDelays) {
    WallRun run = in_and_out(ProxyMode::kHeld, delay);
    run.client.stop[0] = 0.1;  // out of reach
    EXPECT_EQ(haptic::test::run(run).peak_force, 0.0);
  }
}

TEST(EnergyTankBehindANetwork, HoldsUnderAnyNetworkTrouble) {
  WallRun held = in_and_out(ProxyMode::kHeld, 0.0), planes = in_and_out(ProxyMode::kPlanes, 0.0);
  WallRun late_planes = planes;
  late_planes.client.only_in_contact = true;
  for (WallRun run : {held, planes, late_planes}) {
    for (const double rate : {30.0, 60.0, 200.0, 1000.0}) {
      for (const double delay : {0.0, 0.020, 0.050, 0.100}) {
        for (const bool disorder : {false, true}) {
          SCOPED_TRACE(std::to_string(rate) + " Hz " + std::to_string(delay));
          run.client.delay_s = delay;
          run.client.rate_hz = rate;
          run.client.disorder = disorder;
          run.client.lost = disorder ? 0.5 : 0.0;
          run.passivity = wall_tank(1e-3);
          const WallFigures result = haptic::test::run(run);
          EXPECT_LE(result.most_net, 1e-3 + 1e-9);
          EXPECT_LT(result.largest_q, 0.033) << "bounded by the hand";
          EXPECT_GT(result.peak_force, run.client.only_in_contact ? 0.0 : 1.0) << "force was on";
        }
      }
    }
  }
  held.client.delay_s = 0.020;
  late_planes.client.delay_s = 0.050;
  EXPECT_GT(haptic::test::run(held).most_net, 1.0) << "without it, a held proxy pumps joules,";
  EXPECT_GT(haptic::test::run(late_planes).most_net, 1e-3) << "and a late plane gives millijoules";
}

ProxySnapshot with_stops(ProxySnapshot sample) {
  sample.mode = ProxyMode::kPlanes;
  sample.planes.normals = MatXQ::Identity(2, 2);
  sample.planes.offsets = joints(0.3, 0.4);
  return sample;
}

PipelineConfig planes_config() {
  PipelineConfig c = config_of(RendererKind::kSubspaceLinear);
  c.scene.engage_window = one(1e3);
  return c;
}

TEST(PlanesInTheTick, ScenesMetricDecidesTheNearestPoint) {
  PipelineConfig weighed = planes_config();
  weighed.projection.metric =
      TaskMetric::from_matrix((Eigen::Matrix2d() << 4.0, 1.5, 1.5, 1.0).finished());
  Bench bench(weighed);
  bench.shape = with_stops;
  bench.put(joints(0.35, 0.2));
  const TickRecord record = bench.engage();
  // 0.05 back along W^-1 (1, 0), which is along (1, -1.5).
  EXPECT_NEAR((record.anchor.x - joints(0.3, 0.275)).norm(), 0.0, 1e-12);
  EXPECT_EQ(record.anchor.active_planes, 1u);
}

TEST(PlanesInTheTick, PlanesThatContradictAreReported) {
  Bench bench(planes_config());
  bench.put(joints(0.35, 0.2));
  bench.shape = [](ProxySnapshot sample) {
    sample = with_stops(sample);
    sample.planes.normals.row(0) << 1.0, -1.0;
    sample.planes.normals.row(1).setZero();
    sample.planes.offsets << 0.3, -0.4;
    return sample;
  };
  const TickRecord record = bench.engage();
  EXPECT_EQ(record.anchor.planes, PlaneStatus::kInfeasible);
  EXPECT_TRUE(record.limiters().has(Limiter::kInfeasiblePlanes));
  EXPECT_NEAR(record.anchor.x[0], 0.35, 1e-5);
}

}  // namespace
}  // namespace haptic::core
