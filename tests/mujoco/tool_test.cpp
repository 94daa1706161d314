/// A MuJoCo simulation on the shipped pipeline, in virtual time.

#include "haptic/mujoco/tool.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "haptic/core/model/linear.hpp"
#include "tests/mujoco/mujoco_world.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::mujoco {
namespace {

using core::VecA;
using core::VecQ;
using core::VecX;

core::PipelineConfig slider_config() {
  core::LinearMap map{.dofs = {{"l", core::Unit::kMetre, true, -0.2, 0.2}},
                      .coordinates = {{"x", core::Unit::kMetre, core::CoordinateKind::kLinear}},
                      .A = core::MatXQ::Identity(1, 1),
                      .x_0 = VecX::Zero(1)};
  core::PipelineConfig c{.kinematics = core::make_linear(map)};
  c.device.q_lower = VecQ::Constant(1, -1.0);
  c.device.q_upper = VecQ::Constant(1, 1.0);
  c.device.max_effort = VecA::Constant(1, 100.0);
  c.scene.stiffness = VecA::Constant(1, kCoupling);
  c.scene.damping = VecA::Zero(1);
  c.scene.force_limit = VecA::Constant(1, 60.0);
  c.scene.slew_limit = VecA::Constant(1, 1e7);
  c.scene.engage_window = VecA::Constant(1, 60.0);
  return c;
}

/// A device that a hand moves along `way(t)`, m.
struct Slider : Held {
  Slider(const std::string& objects, double rate_hz, double delay_s)
      : Held(slider_model(objects)),
        loop(slider_config(), told_by(tool, rate_hz, delay_s, 1), 2.0) {}
  const core::TickRecord& at(double q) { return loop.tick(VecQ::Constant(1, q)); }
  /// Goes from `a` to `b` in `seconds`; returns the largest force outside `wall`.
  double go(double a, double b, double seconds, double wall = 1.0) {
    double outside = 0.0;
    const int ticks = static_cast<int>(seconds * 1000.0);
    for (int k = 1; k <= ticks; ++k) {
      const double q = a + (b - a) * k / ticks;
      at(q);
      if (q < wall) outside = std::max(outside, std::abs(loop.tau()));
    }
    return outside;
  }
  void engage(double q) {
    go(q, q, 0.5);
    loop.engage();
    go(q, q, 0.3);
    loop.require_engaged();
  }
  test::PipelineLoop loop;
};

/// Both slides are along x: what pulls the pen pulls its carriage as much, in every step.
TEST(Tool, CarriersFeelOneStepsPull) {
  Held held(R"(<mujoco><option timestep="0.001" gravity="0 0 0"/><worldbody>
    <body name="carriage"><joint name="slow" type="slide" axis="1 0 0"/>
      <geom type="sphere" size="0.02" mass="5"/>
      <body name="pen"><joint name="x" type="slide" axis="1 0 0"/>
        <geom type="sphere" size="0.01" mass="0.1"/></body></body>
  </worldbody></mujoco>)",
            {point("pen", 0)});
  const World& world = held.world;
  const mjtNum* const applied = world.d()->qfrc_applied;
  for (int i = 0; i < 100; ++i) {
    held.hold({0.01, 0.0, 0.0}, 1);
    ASSERT_DOUBLE_EQ(applied[world.m()->jnt_dofadr[world.id(mjOBJ_JOINT, "slow")]],
                     applied[world.m()->jnt_dofadr[world.id(mjOBJ_JOINT, "x")]]);
  }
  EXPECT_NEAR(world.d()->xpos[3 * world.id(mjOBJ_BODY, "pen")], 0.01, 1e-4);
}

TEST(Tool, HeldForceIsMujocos) {
  for (const double rate : {60.0, 120.0, 500.0}) {
    for (const double delay : {0.0, 0.020, 0.050, 0.100}) {
      SCOPED_TRACE(std::to_string(rate) + "/s, " + std::to_string(delay) + " s");
      Slider run(kSoftWall, rate, delay);
      run.engage(0.0);
      EXPECT_EQ(run.go(0.0, 0.030, 1.0, 0.0195), 0.0);
      run.go(0.030, 0.030, 1.0);
      const double engine = run.force();
      EXPECT_GT(engine, 2.0);
      EXPECT_NEAR(-run.loop.tau(), engine, 0.01 * engine);
      run.go(0.030, 0.0, 1.0);
      EXPECT_EQ(run.loop.tau(), 0.0);
    }
  }
}

/// 200 g on 200 N/m and 2 N s/m, touched at x = 20 mm.
const std::string kPushed = R"(<body pos="0.05 0 0">
    <joint type="slide" axis="1 0 0" stiffness="200" damping="2"/>
    <geom type="box" size="0.02 0.1 0.1" mass="0.2" solref="-50000 -200" solimp="0.5 0.5 0.001"/>
  </body>)";

/// In and out by 18 mm at 0.7 Hz, against the same simulation at 1 kHz without delay.
TEST(Tool, MovingForceIsMujocosToo) {
  for (const auto& [objects, most] : {std::pair{kSoftWall, 0.02}, {kPushed, 0.06}}) {
    for (const double delay : {0.0, 0.050, 0.100}) {
      SCOPED_TRACE(objects + std::to_string(delay));
      Slider run(objects, 60.0, delay), shadow(objects, 1000.0, 0.0);
      run.engage(0.0);
      shadow.engage(0.0);
      double squares = 0.0, peak = 0.0, outside = 0.0;
      int contact = 0;
      for (int k = 0; k < 8000; ++k) {
        const double q = 0.02 - 0.018 * std::cos(2.0 * M_PI * 0.7e-3 * k);
        run.at(q);
        shadow.at(q);
        const double want = shadow.loop.tau(), error = run.loop.tau() - want;
        peak = std::max(peak, std::abs(want));
        if (want == 0.0) {
          outside = std::max(outside, std::abs(run.loop.tau()));
        } else {
          squares += error * error;
          ++contact;
        }
      }
      const double rms = std::sqrt(squares / contact);
      RecordProperty("rms percent " + std::to_string(delay) + (objects == kPushed ? " pushed" : ""),
                     std::to_string(100.0 * rms / peak));
      EXPECT_LE(rms, most * peak);
      EXPECT_LE(outside, 0.02 * peak);
      EXPECT_LE(run.loop.energy().most_net(), 1e-9);
    }
  }
}

TEST(Tool, LateJoinFeelsTheSame) {
  for (const double inside : {0.021, 0.030, 0.045}) {
    SCOPED_TRACE(inside);
    Slider steady(kSoftWall, 60.0, 0.020), late(kSoftWall, 60.0, 0.020);
    steady.go(0.0, inside, 1.0);
    steady.engage(inside);
    late.engage(inside);
    late.go(inside, inside, 1.0);
    steady.go(inside, inside, 1.0);
    EXPECT_LT(late.loop.tau(), -0.1);
    EXPECT_NEAR(late.loop.tau(), steady.loop.tau(), 1e-3 * std::abs(steady.loop.tau()));
    late.go(inside, 0.0, 1.0);
    EXPECT_EQ(late.loop.tau(), 0.0);
  }
}

/// The model is reset while the hand presses: the tool comes back from outside, and the probe is
/// deep inside by then. A pushed object swings meanwhile.
TEST(Tool, ForceReturnsByARamp) {
  for (const std::string& objects : {kSoftWall, kPushed}) {
    for (const double delay : {0.0, 0.050}) {
      SCOPED_TRACE(objects + std::to_string(delay));
      Slider run(objects, 60.0, delay);
      run.engage(0.0);
      run.go(0.0, 0.045, 1.0);
      run.go(0.045, 0.045, 1.0);
      const double held = -run.loop.tau();
      EXPECT_GT(held, 2.0);
      mj_resetData(run.world.m(), run.world.d());
      run.go(0.045, 0.045, 0.1);
      EXPECT_EQ(run.loop.tau(), 0.0);
      double most = 0.0, ahead = 0.0;
      int begun = 0;
      for (int k = 1; k <= 1500; ++k) {
        run.at(0.045);
        most = std::max(most, run.force());
        if (begun == 0 && run.loop.tau() < 0.0) begun = k;
        if (begun == 0) continue;
        // Samples come every 17 ms, each with its share.
        const double part = std::min(1.0, (k - begun + 17) / 200.0);
        ahead = std::max(ahead, -run.loop.tau() - part * most);
      }
      EXPECT_LE(ahead, 0.02 * most);
      EXPECT_NEAR(-run.loop.tau(), held, 0.01 * held);
    }
  }
}

/// A client that waited in a debugger: the probe is elsewhere when it goes on.
TEST(Tool, PauseBringsTheToolBackSlowly) {
  Held held(slider_model(kSoftWall));
  held.hold({-0.1}, 20);
  EXPECT_TRUE(held.tool.following());
  const mjtNum& place = held.world.d()->qpos[0];
  double before = place, fastest = 0.0;
  int samples = 0;
  for (; samples < 100; ++samples) {
    const client::Proxy proxy = held.hold({0.030}, 1);
    fastest = std::max(fastest, 60.0 * (place - before));
    before = place;
    if (held.tool.following()) break;
    EXPECT_EQ(proxy.mode, client::Mode::kFree);
  }
  EXPECT_NEAR(samples / 60.0, 0.13 / 0.5, 0.05);
  EXPECT_LT(fastest, 0.6);
  const client::Proxy proxy = held.hold({0.030});
  ASSERT_EQ(proxy.planes.size(), 1u);
  EXPECT_GT(held.force(), 2.0);
  EXPECT_NEAR(proxy.position[0], 0.030 - held.force() / kCoupling, 1e-9);
}

/// Held still, what is published is where the tool is: spring and metric of the wire are the same.
TEST(Tool, PoseRestsWhereItIsPublished) {
  Held held(R"(<mujoco><option timestep="0.001"/><worldbody>
    <body name="pen" pos="0 0 0.1"><freejoint/>
      <geom type="capsule" fromto="0 0 0 0.06 0 0.01" size="0.01" mass="0.05" condim="1"/></body>
    <geom type="plane" size="1 1 1" condim="1" solref="-3000 -60" solimp="0.5 0.5 0.001"/>
  </worldbody></mujoco>)",
            {pose("pen", 1)},
            {.coupling = 400.0, .weights = {1, 1, 1, 1, 0.004, 0.004, 0.004, 0.004}});
  const std::vector<double> probe{7.0, 0.0, 0.0, 0.02, 0.1, -0.2, 0.05, -std::sqrt(0.9475)};
  const client::Proxy proxy = held.hold(probe, 240);
  const mjtNum* const qpos = held.world.d()->qpos;
  ASSERT_EQ(proxy.mode, client::Mode::kPlanes);
  EXPECT_GT(held.force(), 0.2);
  EXPECT_EQ(proxy.position[0], 7.0) << "not bound";
  double turned = 0.0;
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(proxy.position[1 + k], qpos[k], 2e-5);
  for (std::size_t k = 0; k < 4; ++k) {
    const double here = -qpos[3 + (k + 1) % 4];  // as the probe has its sign
    EXPECT_NEAR(proxy.position[4 + k], here, 1e-3);
    turned = std::max(turned, std::abs(proxy.position[4 + k] - probe[4 + k]));
  }
  EXPECT_GT(turned, 0.02);
}

TEST(Tool, PointsRestWhereTheyArePublished) {
  Held held(R"(<mujoco><option timestep="0.001"/><worldbody>
    <body name="pad" pos="0 0 0.05"><joint type="slide" axis="1 0 0"/><joint type="slide"
      axis="0 1 0"/><joint type="slide" axis="0 0 1"/>
      <geom type="sphere" size="0.01" mass="0.02" condim="1"/></body>
    <geom type="sphere" pos="0.01 0 0" size="0.03" condim="1"/></worldbody></mujoco>)",
            {point("pad", 0)}, {.coupling = 500.0});
  const client::Proxy proxy = held.hold({0.015, 0.01, 0.030}, 240);
  EXPECT_GT(held.force(), 0.5);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(proxy.position.at(k), held.world.d()->xpos[3 + k], 1e-5);
  }
}

TEST(Tool, FreeMotionIsTheProbe) {
  Held held(slider_model(R"(<body pos="0.1 0 0"><joint type="slide" axis="1 0 0"/>
                            <geom type="sphere" size="0.01" mass="0.1"/></body>)"));
  double largest = 0.0, told = 0.0;
  for (int i = 0; i < 300; ++i) {
    const double probe = 0.04 * std::sin(i / 10.0);  // 0.24 m/s
    const client::Proxy proxy = held.hold({probe}, 1, 100);
    for (const client::Plane& plane : proxy.planes) {
      EXPECT_EQ(proxy.position[0], probe);
      EXPECT_GT(plane.offset - plane.normal[0] * probe, 0.0);
      told = std::max(told, plane.offset - plane.normal[0] * probe);
    }
    largest = std::max(largest, std::abs(held.world.d()->qpos[0] - probe));
  }
  EXPECT_LT(largest, 0.001) << "the tool lags";
  EXPECT_GT(told, 0.040) << "told before it is touched";
}

TEST(Tool, OddProbesAreNotFollowed) {
  Held held(slider_model(kSoftWall));
  for (const std::vector<double>& odd :
       {std::vector<double>{}, {std::nan("")}, {HUGE_VAL}, {1e300}}) {
    EXPECT_EQ(held.hold(odd, 1).mode, client::Mode::kFree);
    EXPECT_LT(std::abs(held.world.d()->qpos[0]), 1.0);
  }
}

TEST(Tool, LimitsOfJointsDoNotHold) {
  Held held(R"(<mujoco><option gravity="0 0 -9.81"/><worldbody><body>
    <joint name="x" type="slide" axis="0 0 1" limited="true" range="-0.01 0.01" stiffness="50"
           damping="1"/><geom type="sphere" size="0.01" mass="0.1"/></body></worldbody></mujoco>)",
            {joint("x", 0)}, {.coupling = 300.0});
  held.hold({0.05}, 120);
  EXPECT_NEAR(held.world.d()->qpos[0], 0.05, 1e-6)
      << "nor do weight, spring and friction of the joint";
}

TEST(Tool, ForceBeginsWhereTheModelSays) {
  Held held(slider_model(
      R"(<geom type="box" pos="0.08 0 0" size="0.05 0.1 0.1" margin="0.004" gap="0.001"/>)"));
  for (const double probe : {0.0165, 0.0175}) {  // force from 3 mm on, x = 17 mm
    ASSERT_EQ(held.hold({probe}).planes.size(), 1u);
    EXPECT_EQ(held.force() > 0.0, probe > 0.017) << probe;
  }
}

TEST(Tool, FullListNarrowsTheHorizon) {
  std::string model = slider_model(kSoftWall);
  for (int i = 0; i < 12; ++i) {
    model.insert(model.find("<body name"), R"(<geom type="sphere" size="0.001" pos="0.02 0.0)" +
                                               std::to_string(30 + i) + R"( 0"/>)");
  }
  model.insert(model.find("<default>"), R"(<size nconmax="4"/>)");
  Held held(model);
  held.hold({0.025}, 60, 100);
  EXPECT_GT(held.world.d()->warning[mjWARN_CONTACTFULL].number, 0);
  EXPECT_GT(held.force(), 1.0) << "the wall is found again";
  EXPECT_NEAR(held.world.d()->qpos[0], 0.025 - held.force() / kCoupling, 1e-6);
}

TEST(Tool, RefusalsNameTheBinding) {
  World world(R"(<mujoco><worldbody><body name="free"><freejoint name="six"/>
    <geom type="sphere" size="0.05"/></body><body><joint name="x" type="slide"/>
    <geom type="sphere" size="0.01"/></body></worldbody></mujoco>)");
  const auto with = [&](const std::vector<Binding>& bindings, const ToolOptions& options) {
    return test::message_of<std::invalid_argument>(
        [&] { return Tool(world.m(), world.d(), bindings, options); });
  };
  using testing::HasSubstr;
  EXPECT_THAT(with({joint("y", 0)}, {.coupling = 1.0}), HasSubstr("'y': the model has no joint"));
  EXPECT_THAT(with({joint("six", 0)}, {.coupling = 1.0}), HasSubstr("'six': must be a hinge"));
  EXPECT_THAT(with({pose("y", 0)}, {.coupling = 1.0}), HasSubstr("'y': the model has no site"));
  EXPECT_THAT(with({pose("world", 0)}, {.coupling = 1.0}), HasSubstr("cannot move"));
  EXPECT_THAT(with({joint("x", 0, 0.0)}, {.coupling = 1.0}), HasSubstr("scale"));
  EXPECT_THAT(with({joint("x", 0)}, {}), HasSubstr("coupling 0"));
  EXPECT_THAT(with({joint("x", 0)}, {.coupling = 1e6}), HasSubstr("too stiff"));
  EXPECT_THAT(with({joint("x", 0)}, {.coupling = 1.0, .weights = {0.0}}), HasSubstr("weight"));
  EXPECT_THAT(with({joint("x", 1)}, {.coupling = 1.0, .weights = {1.0}}),
              HasSubstr("'x': coordinate 1 has no weight"));
  for (const std::size_t far : {std::size_t{10000}, SIZE_MAX}) {
    EXPECT_THAT(with({joint("x", far)}, {.coupling = 1.0}), HasSubstr("'x': coordinate "));
    EXPECT_THAT(with({pose("free", far - 3)}, {.coupling = 1.0}), HasSubstr("'free': coordinate "));
  }
  EXPECT_THAT(with({pose("free", 0), joint("x", 6)}, {.coupling = 1.0}), HasSubstr("bound twice"));
  Tool tool(world.m(), world.d(), {joint("x", 2)}, {.coupling = 1.0});
  const auto aim = [&](const std::vector<double>& probe, int steps) {
    return test::message_of<std::invalid_argument>([&] { tool.aim(probe, steps); });
  };
  EXPECT_THAT(aim({0.0, 0.0}, 1), HasSubstr("coordinate 2 is bound"));
  EXPECT_THAT(aim({0.0, 0.0, 0.0}, 0), HasSubstr("steps 0"));
}

}  // namespace
}  // namespace haptic::mujoco
