// A client in the loop (core/METHOD.md#results, core/METHOD.md#energy-tank): with the proxy held
// the exact method is conservative, with a client that computes x from q it is not, and the tank is
// what bounds the energy.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/tick/finger_bench.hpp"
#include "tests/support/angles.hpp"

namespace haptic::core {
namespace {

using namespace test;

struct Cycle {
  double returned{0.0};  ///< work on the user per cycle, J
  double peak{0.0};      ///< largest potential of the spring, J
  double lowest{0.0};    ///< level of the tank, J
  double motion{0.0};    ///< integral of v^2 dt, m^2/s: times b, what the device's damping takes
};

/// The last of three cycles of 1 s: l_x +-2 mm, q_B +-0.05 rad a quarter later, about x = (30, 30)
/// deg; the client stops the MCP joint at 18 deg in every tick, without delay. direction: +1 or -1.
Cycle cycle_against_an_mcp_stop(const PipelineConfig& config, int direction) {
  constexpr int kTicks = 1000;
  Bench bench(config);
  const VecX centre = joints(30 * kDegree, 30 * kDegree);
  VecQ q_centre(2);
  EXPECT_EQ(config.kinematics->inverse(centre, q_centre), InverseStatus::kExact);
  MatXQ J(2, 2);
  VecX x(2);
  const auto at = [&](int k) {
    const double phase = direction * 2.0 * M_PI * k / kTicks;
    VecQ q = q_centre;
    q[0] += 0.002 * std::cos(phase);
    q[1] += 0.05 * std::sin(phase);
    EXPECT_EQ(config.kinematics->evaluate(q, x, J), MapStatus::kOk);
    bench.input.device.sample.q = q;
    bench.target = joints(std::min(x[0], 18 * kDegree), x[1]);
  };
  at(0);
  bench.engage();
  Cycle cycle;
  TickRecord last = bench.tick();
  for (int k = 1; k <= 3 * kTicks; ++k) {
    at(k);
    const TickRecord record = bench.tick();
    if (k > 2 * kTicks) {
      const double dq = record.sensed.q[0] - last.sensed.q[0];
      cycle.returned += last.effort.tau_a[0] * dq;
      cycle.motion += dq * dq / 1e-3;
      const double d = record.effort.q_star[0] - record.sensed.q[0];
      cycle.peak = std::max(cycle.peak, 0.5 * kStiffness * d * d);
      cycle.lowest = std::min(cycle.lowest, record.effort.passivity.tank);
    }
    last = record;
  }
  return cycle;
}

TEST(ClosedLoop, ClientMakesExactPumpOneWay) {
  const PipelineConfig config = config_of(RendererKind::kSubspaceExact);
  const Cycle forward = cycle_against_an_mcp_stop(config, +1);
  const Cycle backward = cycle_against_an_mcp_stop(config, -1);
  const double pumped = std::max(forward.returned, backward.returned);
  const double absorbed = std::min(forward.returned, backward.returned);
  EXPECT_NEAR(pumped / forward.peak, 0.81, 0.02);
  EXPECT_NEAR(absorbed / forward.peak, -0.81, 0.02);
}

TEST(ClosedLoop, TankBoundsACyclesReturn) {
  constexpr double kDeviceDamping = 2.0;  // N s/m
  for (const RendererKind renderer : kEveryRenderer) {
    double most = 0.0;
    for (const int direction : {+1, -1}) {
      SCOPED_TRACE(std::string(name(renderer)) + (direction > 0 ? " forward" : " backward"));
      PipelineConfig config = with_tank(renderer, 0.0);
      config.passivity.device_damping = VecA::Constant(1, kDeviceDamping);
      const Cycle cycle = cycle_against_an_mcp_stop(config, direction);
      EXPECT_LE(cycle.returned - kDeviceDamping * cycle.motion, 1e-9);
      EXPECT_GE(cycle.lowest, -1e-15) << "no debt: the device's damping pays the hold's leak";
      config.passivity = {};
      most = std::max(most, cycle_against_an_mcp_stop(config, direction).returned);
    }
    EXPECT_GT(most, 1e-3) << "without the tank one direction returns millijoules";
  }
}

}  // namespace
}  // namespace haptic::core
