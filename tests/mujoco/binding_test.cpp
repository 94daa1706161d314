#include "haptic/mujoco/binding.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <clocale>
#include <tuple>

#include "tests/mujoco/mujoco_world.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::mujoco {
namespace {

const char* const kBodies = R"(<mujoco><worldbody>
  <body name="palm"><freejoint/><geom size="0.01"/><site name="wrist"/>
    <body><joint name="index.q_o1_mcp"/><geom size="0.01"/></body></body></worldbody></mujoco>)";

const char* const kCommas[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "fr_FR.utf8"};

std::vector<client::VirtualCoordinate> named(const std::vector<std::string>& names) {
  std::vector<client::VirtualCoordinate> all;
  for (const std::string& name : names) all.push_back({name, "", ""});
  return all;
}

std::string complaint(const World& world, const std::vector<std::string>& names,
                      const std::vector<std::string>& joints = {}) {
  return test::message_of<std::invalid_argument>(
      [&] { return by_name(*world.m(), named(names), joints); });
}

TEST(Binding, NamesTellJointsPointsAndPoses) {
  const World world(kBodies);
  const std::vector<Binding> bound =
      by_name(*world.m(), named({"index.q_o1_mcp", "wrist.x", "wrist.y", "wrist.z", "palm.x",
                                 "palm.y", "palm.z", "palm.qx", "palm.qy", "palm.qz", "palm.qw"}));
  ASSERT_EQ(bound.size(), 3u);
  EXPECT_EQ(bound[0].kind, Binding::Kind::kJoint);
  EXPECT_EQ(bound[0].name, "index.q_o1_mcp");
  EXPECT_EQ(bound[1].kind, Binding::Kind::kPoint);
  EXPECT_EQ(bound[1].name, "wrist");
  EXPECT_EQ(bound[1].first_coordinate, 1u);
  EXPECT_EQ(bound[2].kind, Binding::Kind::kPose);
  EXPECT_EQ(bound[2].first_coordinate, 4u);
}

TEST(Binding, JointsMayCountOtherwise) {
  const World world(kBodies);
  const std::vector<std::string> device{"wrist.x", "wrist.y", "wrist.z", "mcp"};
  for (const auto& [text, scale, offset] : {std::tuple{"index.q_o1_mcp=mcp", 1.0, 0.0},
                                            {"index.q_o1_mcp=mcp,-1", -1.0, 0.0},
                                            {"index.q_o1_mcp=mcp,-2,0.25", -2.0, 0.25}}) {
    const std::vector<Binding> bound = by_name(*world.m(), named(device), {text});
    ASSERT_EQ(bound.size(), 2u) << text;
    EXPECT_EQ(bound[0].name, "index.q_o1_mcp");
    EXPECT_EQ(bound[0].first_coordinate, 3u);
    EXPECT_EQ(bound[0].scale, scale);
    EXPECT_EQ(bound[0].offset, offset);
    EXPECT_EQ(bound[1].name, "wrist");
  }
  for (const char* bad :
       {"mcp", "a=pip", "a=mcp,", "a=mcp,x", "a=mcp,1x", "a=mcp,nan", "a=mcp,1,", "a=mcp,1,2,3"}) {
    EXPECT_NE(complaint(world, device, {bad}).find("joint '" + std::string(bad) + "'"),
              std::string::npos)
        << bad;
  }
}

/// The joint of the coordinate's own name leads.
TEST(Binding, OneCoordinateMayMoveSeveralJoints) {
  const World world(R"(<mujoco><worldbody><body><joint name="pip"/><geom size="0.01"/>
    <body><joint name="dip"/><geom size="0.01"/></body></body></worldbody></mujoco>)");
  const std::vector<Binding> bound = by_name(*world.m(), named({"pip"}), {"dip=pip,0.67"});
  ASSERT_EQ(bound.size(), 2u);
  EXPECT_EQ(bound[0].name, "pip");
  EXPECT_EQ(bound[1].name, "dip");
  EXPECT_EQ(bound[1].first_coordinate, 0u);
  EXPECT_EQ(by_name(*world.m(), named({"pip"}), {"pip=pip,-1"}).size(), 1u);
  EXPECT_NE(test::message_of<std::invalid_argument>([&] {
              Tool(world.m(), world.d(), {joint("pip", 0), joint("pip", 1)}, {.coupling = 0.01});
            }).find("'pip': the joint is bound twice"),
            std::string::npos);
}

TEST(Binding, NumbersAreReadInNoLocale) {
  const World world(kBodies);
  const std::string before = std::setlocale(LC_ALL, nullptr);
  const bool comma = std::any_of(std::begin(kCommas), std::end(kCommas), [](const char* name) {
    return std::setlocale(LC_ALL, name) != nullptr;
  });
  const std::vector<Binding> bound =
      by_name(*world.m(), named({"mcp"}), {"index.q_o1_mcp=mcp,-0.5"});
  std::setlocale(LC_ALL, before.c_str());
  EXPECT_EQ(bound.at(0).scale, -0.5);
  if (!comma) GTEST_SKIP() << "no locale with decimal commas is here";
}

TEST(Binding, NamesThatMeanNothingAreRefused) {
  const World world(kBodies);
  EXPECT_NE(complaint(world, {"elbow"}).find("'elbow'"), std::string::npos);
  EXPECT_NE(complaint(world, {"tip.x", "tip.y", "tip.z"}).find("'tip'"), std::string::npos);
  EXPECT_NE(complaint(world, {"wrist.x", "wrist.y"}).find("'wrist.x'"), std::string::npos);
}

}  // namespace
}  // namespace haptic::mujoco
