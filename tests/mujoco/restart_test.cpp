/// A tool whose model is suddenly elsewhere: reset, a key, a bad state, a qpos set by hand.

#include <gtest/gtest.h>

#include "tests/mujoco/mujoco_world.hpp"

namespace haptic::mujoco {
namespace {

/// Force that the device is told to feel, N.
double told(const client::Proxy& proxy, double probe) {
  return proxy.position.empty() ? 0.0 : kCoupling * std::abs(proxy.position[0] - probe);
}

struct Slid : Held {
  Slid() : Held(slider_model(kSoftWall)) {
    hold({0.0});
    EXPECT_TRUE(tool.following());
  }
  /// The largest force of 2 s at 1 kHz, after which the tool must follow.
  double goes_to(double probe) {
    double most = 0.0;
    for (int i = 0; i < 2000; ++i) {
      most = std::max(most, told(tool.step({probe}, 1e-3), probe));
    }
    EXPECT_TRUE(tool.following());
    return most;
  }
};

TEST(Restart, KeyOfAnyTimeIsOne) {
  for (const double time : {0.0, 0.9, 1.1, 100.0}) {
    SCOPED_TRACE(time);
    Slid run;
    mj_resetData(run.world.m(), run.world.d());
    run.world.d()->time = time;
    run.world.d()->qpos[0] = 0.10;  // inside the wall
    EXPECT_EQ(run.goes_to(0.0), 0.0);
  }
}

TEST(Restart, CallerMaySayIt) {
  Slid run;
  run.world.d()->qpos[0] = 0.10;
  run.tool.restart();
  EXPECT_FALSE(run.tool.following());
  EXPECT_EQ(run.tool.proxy().mode, client::Mode::kFree);
  EXPECT_EQ(run.goes_to(0.0), 0.0);
}

std::vector<std::string>* warnings = nullptr;

TEST(Restart, PairsInsideAreSaidOnce) {
  std::vector<std::string> said;
  warnings = &said;
  World apart(slider_model(kSoftWall)), inside(slider_model(kSoftWall));
  mju_user_warning = [](const char* text) { warnings->emplace_back(text); };
  Tool outside(apart.m(), apart.d(), {joint("x", 0)}, {.coupling = kCoupling});
  EXPECT_TRUE(said.empty());
  inside.d()->qpos[0] = 0.10;
  Tool tool(inside.m(), inside.d(), {joint("x", 0)}, {.coupling = kCoupling});
  tool.restart();
  mju_user_warning = nullptr;
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].find("geom 'wall' and geom 'tip'"), std::string::npos) << said[0];
}

/// The tool was brought round a wall, and MuJoCo puts it back behind it, within a sample.
TEST(Restart, BadStateIsALateJoin) {
  for (const int bad : {0, 7, 15}) {
    SCOPED_TRACE(bad);
    Held held(slider_model(
        R"(<geom type="box" pos="-0.05 0 0" size="0.005 0.1 0.1" solref="-12500 -50"
             solimp="0.5 0.5 0.001"/>)"));
    auto& [world, tool] = held;
    held.hold({0.0});
    world.d()->qpos[0] = -0.10;
    tool.restart();
    held.hold({-0.10});
    ASSERT_TRUE(tool.following());
    tool.aim({-0.10}, 16);
    for (int k = 0; k < 16; ++k) {
      tool.pull();
      if (k == bad) world.d()->qvel[0] = 1e20;
      mj_step(world.m(), world.d());
    }
    for (int frame = 0; frame < 5; ++frame) {
      EXPECT_EQ(tool.proxy().mode, client::Mode::kFree);
      EXPECT_FALSE(tool.following());
      EXPECT_GT(world.d()->qpos[0], -0.02) << "it begins where the model has it";
      tool.aim({-0.10}, 4);
      for (int k = 0; k < 4; ++k) {
        tool.pull();
        mj_step(world.m(), world.d());
      }
    }
  }
}

TEST(Restart, BadStateInTheFirstStep) {
  Held held(slider_model(kSoftWall));
  auto& [world, tool] = held;
  world.d()->qpos[0] = 0.10;
  tool.restart();
  tool.aim({0.10}, 1);
  EXPECT_TRUE(tool.following());
  tool.pull();
  world.d()->qvel[0] = 1e20;
  mj_step(world.m(), world.d());  // then data->time is as after any first step
  EXPECT_EQ(tool.proxy().mode, client::Mode::kFree);
  EXPECT_FALSE(tool.following());
}

TEST(Restart, PosesWithoutATurnPassBy) {
  Held held(R"(<mujoco><option timestep="0.001" gravity="0 0 0"/><worldbody>
    <geom type="plane" pos="0 0 -0.05" size="1 1 1"/>
    <body name="pen"><freejoint/><geom type="sphere" size="0.03" mass="0.3"/></body>
  </worldbody></mujoco>)",
            {pose("pen", 0)}, {.coupling = 20.0});
  const auto after = [&](const std::vector<double>& probe) { return held.hold(probe, 30); };
  const mjData* const data = held.world.d();
  for (const double part : {0.0, 9e-4, 1e-320, 1.7e308}) {
    SCOPED_TRACE(part);
    EXPECT_EQ(after({0, 0, -0.03, 0, 0, 0, 1}).planes.size(), 1u);
    EXPECT_EQ(after({0, 0, 0, 0, part > 1.0 ? part : 0.0, 0, part}).mode, client::Mode::kFree);
    EXPECT_LT(data->qpos[2], -0.01) << "it stays";
  }
  EXPECT_EQ(after({0, 0, -0.03, 0, 0, 0, 2e-3}).planes.size(), 1u) << "short, but a turn";
  EXPECT_EQ(data->warning[mjWARN_BADQACC].number, 0);
}

}  // namespace
}  // namespace haptic::mujoco
