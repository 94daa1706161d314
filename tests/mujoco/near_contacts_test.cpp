/// MuJoCo's contacts as they are told: gap, gradient and curvature against MuJoCo at other places
/// of the tool, the law of what is pushed, and the life of an id.

#include "near_contacts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/mujoco/mujoco_world.hpp"

namespace haptic::mujoco {
namespace {

/// Tool, model and what is found, without a device.
struct Still {
  Still(const std::string& mjcf, const std::vector<Binding>& bindings)
      : Still(World(mjcf), bindings) {}
  Still(World w, const std::vector<Binding>& bindings)
      : world(std::move(w)),
        tool((mj_forward(world.m(), world.d()), *world.m()), *world.d(), bindings,
             {.coupling = 1e-3}),
        contacts(tool),
        rate(static_cast<std::size_t>(world.m()->nv), 0.0) {
    look_ahead(1.0);
  }
  /// Contacts are told from so far away on, m, without force.
  void look_ahead(double margin) {
    for (int geom = 0; geom < world.m()->ngeom; ++geom) {
      world.m()->geom_margin[geom] = world.m()->geom_gap[geom] = margin;
    }
  }
  /// Lets what lies around come to rest in 3 s, with what touches it alone; then the tool looks 1 m
  /// ahead.
  void settle() {
    look_ahead(0.0);
    for (int i = 0; i < 3000; ++i) mj_step(world.m(), world.d());
    const int tip = world.id(mjOBJ_GEOM, "tip");
    world.m()->geom_margin[tip] = world.m()->geom_gap[tip] = 1.0;
  }
  std::vector<NearContact> find() {
    mj_forward(world.m(), world.d());
    x.assign(tool.coordinates(), 0.0);
    tool.read(*world.d(), x);
    return contacts.find(*world.m(), *world.d(), x, rate);
  }
  World world;
  BoundTool tool;
  NearContacts contacts;
  std::vector<mjtNum> rate;
  std::vector<double> x{};
};

/// The gap that a plane says for x.
double gap_at(const client::Plane& plane, const std::vector<double>& x0,
              const std::vector<double>& x) {
  double gap = plane.offset;
  for (std::size_t i = 0; i < x.size(); ++i) gap -= plane.normal[i] * x[i];
  std::size_t entry = 0;
  for (std::size_t j = plane.first_coordinate; entry < plane.curvature.size(); ++j) {
    for (std::size_t k = plane.first_coordinate; k <= j; ++k, ++entry) {
      gap += (j == k ? 0.5 : 1.0) * plane.curvature[entry] * (x[j] - x0[j]) * (x[k] - x0[k]);
    }
  }
  return gap;
}

/// Moves every DoF of the tool by `way` at random; the gaps told before must be those found then,
/// but for the third order, or for the second if the tool is not round.
void compare(Still& still, double way, double third) {
  const auto told = still.find();
  const std::vector<double> x0 = still.x;
  ASSERT_FALSE(told.empty());
  const std::vector<mjtNum> qpos(still.world.d()->qpos,
                                 still.world.d()->qpos + still.world.m()->nq);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int i = 0; i < 20; ++i) {
    std::vector<mjtNum> move(static_cast<std::size_t>(still.world.m()->nv));
    for (int dof = 0; dof < still.world.m()->nv; ++dof) {
      if (still.tool.owns_dof(dof)) move[static_cast<std::size_t>(dof)] = way * uniform(random);
    }
    std::copy(qpos.begin(), qpos.end(), still.world.d()->qpos);
    mj_integratePos(still.world.m(), still.world.d()->qpos, move.data(), 1.0);
    const auto there = still.find();
    ASSERT_EQ(there.size(), told.size());
    for (std::size_t k = 0; k < told.size(); ++k) {
      const client::Plane plane = client::contact_at(x0, told[k].contact, 1.0);
      EXPECT_NEAR(gap_at(plane, x0, still.x), there[k].contact.gap, third * way * way * way);
      EXPECT_EQ(there[k].contact.id, told[k].contact.id);
    }
  }
  std::copy(qpos.begin(), qpos.end(), still.world.d()->qpos);
}

TEST(NearContacts, FingersGapsToSecondOrder) {
  // Joints as they are, and with other signs, scales, offsets and places.
  const std::vector<Binding> as_named{joint("q_o1_mcp", 0), joint("q_o2_pip", 1)};
  const std::vector<Binding> scaled{joint("q_o1_mcp", 3, -2.0, 0.1), joint("q_o2_pip", 1, 0.5)};
  for (const auto& bindings : {as_named, scaled}) {
    SCOPED_TRACE("first coordinate " + std::to_string(bindings.front().first_coordinate));
    Still still(
        World::of_file(std::string(HAPTIC_SOURCE_DIR) + "/client/mujoco/examples/finger.xml"),
        bindings);
    still.world.d()->qpos[0] = 0.4;
    still.world.d()->qpos[1] = 0.5;
    // The ball alone: a box' edges turn the normal beyond the second order.
    const int box = still.world.id(mjOBJ_GEOM, "box");
    still.world.m()->geom_contype[box] = still.world.m()->geom_conaffinity[box] = 0;
    EXPECT_GE(still.find().size(), 2u);
    compare(still, 1e-3, 50.0);
  }
}

TEST(NearContacts, FreeToolsGapsToSecondOrder) {
  const std::string pose_begin =
      R"(<body name="tool" pos="0.01 0 0.02" euler="10 20 30"><freejoint/>)";
  const std::string point_begin =
      R"(<body><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
         <joint type="slide" axis="0 0 1"/><site name="tool"/>)";
  for (const char* object :
       {R"(<geom type="plane" pos="0 0 -0.05" size="1 1 1"/>)",
        R"(<geom type="sphere" pos="0.02 0.01 -0.05" size="0.02"/>)",
        R"(<geom type="capsule" fromto="-1 0.01 -0.05  1 -0.03 -0.06" size="0.02"/>)"}) {
    for (const char* round : {R"(<geom type="sphere" pos="0.03 0.02 0" size="0.01"/>)",
                              R"(<geom type="sphere" size="0.01"/>)"}) {
      SCOPED_TRACE(std::string(object) + round);
      const std::string rest = std::string(round) + "</body>" + object + "</worldbody></mujoco>";
      Still posed("<mujoco><worldbody>" + pose_begin + rest, {pose("tool", 2)});
      compare(posed, 1e-3, 200.0);
      Still moved("<mujoco><worldbody>" + point_begin + rest, {point("tool", 0)});
      compare(moved, 1e-3, 500.0);
    }
  }
}

TEST(NearContacts, TwoFingersTouchEachOther) {
  Still still(R"(<mujoco><worldbody>
    <body><joint name="a" type="hinge" axis="0 0 1"/>
      <geom type="sphere" pos="0.05 0 0" size="0.01" mass="0.01"/></body>
    <body pos="0 0.05 0"><joint name="b" type="hinge" axis="0 0 1"/>
      <geom type="sphere" pos="0.05 0 0" size="0.01" mass="0.01"/></body>
  </worldbody></mujoco>)",
              {joint("a", 0), joint("b", 1)});
  const auto found = still.find();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].contact.gap, 0.03, 1e-12);
  compare(still, 1e-3, 50.0);
}

TEST(NearContacts, BodiesWithOneMiddleAreFlat) {
  const std::string ball = R"(<geom type="sphere" pos="0.05 0 0" size="0.01" mass="0.01"/></body>)";
  Still still("<mujoco><worldbody><body><joint name=\"a\" type=\"hinge\" axis=\"0 0 1\"/>" + ball +
                  "<body><joint name=\"b\" type=\"hinge\" axis=\"0 0 1\"/>" + ball + "<body>" +
                  ball + "</worldbody></mujoco>",
              {joint("a", 0), joint("b", 1)});
  const auto found = still.find();
  ASSERT_EQ(found.size(), 3u);
  for (const NearContact& each : found) {
    EXPECT_EQ(each.contact.curvature, client::Curvature3{});
    for (const double part : each.contact.normal) EXPECT_TRUE(std::isfinite(part));
  }
}

TEST(NearContacts, PushedObjectHasItsOwnLaw) {
  // Along its rail at 60 degrees to the normal: surface and rail differ by cos 60.
  Still still(
      slider_model(R"(<body pos="0.05 0 0"><joint type="slide" axis="0.5 0.8660254037844386 0"
      stiffness="200" damping="3" springref="0.002"/>
      <geom type="box" size="0.02 1 1" mass="0.3"/></body>)"),
      {joint("x", 0)});
  still.world.d()->qpos[1] = 0.001;
  still.rate[1] = still.world.d()->qvel[1] = 0.1;
  const auto found = still.find();
  ASSERT_EQ(found.size(), 1u);
  const client::Contact& c = found[0].contact;
  const double cosine = 0.5, square = cosine * cosine;
  EXPECT_NEAR(c.gap, 0.02 + cosine * 0.001, 1e-9);
  EXPECT_NEAR(c.mass, 0.3 / square, 1e-9);
  EXPECT_NEAR(c.damping, 3.0 / square, 1e-9);
  EXPECT_NEAR(c.ground_stiffness, 200.0 / square, 1e-6);
  EXPECT_NEAR(c.velocity, cosine * 0.1, 1e-12);
  EXPECT_NEAR(c.load, 200.0 * 0.001 / cosine, 1e-9);
}

TEST(NearContacts, LoadLeavesOutThisContact) {
  Still still(slider_model(R"(<body pos="0.05 0 0"><joint type="slide" axis="1 0 0"/>
      <geom type="box" size="0.0205 1 1" mass="0.3"/></body>)"),
              {joint("x", 0)});
  still.world.d()->qpos[0] = 0.02;
  still.world.d()->qfrc_applied[1] = -0.7;
  const auto found = still.find();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_GT(found[0].force, 0.01);
  EXPECT_NEAR(found[0].contact.load, -0.7, 1e-9);
}

TEST(NearContacts, ContactsOfOneBodyShareIt) {
  const std::string ball = R"(<geom type="sphere" size="0.01" mass="0.02"/></body>)";
  Still still(
      R"(<mujoco><option gravity="0 0 0"/><default><geom condim="1"/></default><worldbody>
    <body pos="-0.0299 0.01 0"><joint name="a" type="slide" axis="1 0 0"/>)" +
          ball + R"(<body pos="0.0299 0.004 0.005"><joint name="b" type="slide" axis="1 0 0"/>)" +
          ball + R"(<body pos="-0.008 0.0299 0"><joint name="c" type="slide" axis="0 1 0"/>)" +
          ball + R"(<body><freejoint/><geom type="box" size="0.02 0.02 0.02" mass="0.3"/></body>
  </worldbody></mujoco>)",
      {joint("a", 0), joint("b", 1), joint("c", 2)});
  std::vector<NearContact> found;
  for (const NearContact& near : still.find()) {
    if (near.contact.mass > 0.0) found.push_back(near);
  }
  ASSERT_EQ(found.size(), 3u);
  constexpr double kMass = 0.3, kInertia = kMass * (0.04 * 0.04 + 0.04 * 0.04) / 12.0;
  // The normals lie along x and y, so what turns the box is z and y of its arms.
  const auto turn = [](const Vector3& r, const Vector3& n) {
    return Vector3{r[1] * n[2] - r[2] * n[1], r[2] * n[0] - r[0] * n[2], r[0] * n[1] - r[1] * n[0]};
  };
  const auto moves = [&](const client::Contact& a, const client::Contact& b) {
    return dot(a.normal, b.normal) / kMass +
           dot(turn(a.point.position, a.normal), turn(b.point.position, b.normal)) / kInertia;
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const client::Contact& a = found[i].contact;
    EXPECT_NEAR(1.0 / a.mass, moves(a, a), 1e-6 * moves(a, a));
    EXPECT_EQ(a.object, found[0].contact.object);
    EXPECT_GT(found[i].force, 0.0);
    EXPECT_NEAR(a.load, 0.0, 1e-6 * found[i].force) << "nothing else pushes the box";
    for (std::size_t j = 0; j < 3; ++j) {
      const client::Contact& b = found[j].contact;
      double cosine = 0.0;
      for (std::size_t k = 0; k < std::min(a.object_direction.size(), b.object_direction.size());
           ++k) {
        cosine += a.object_direction[k] * b.object_direction[k];
      }
      EXPECT_NEAR(cosine, moves(a, b) / std::sqrt(moves(a, a) * moves(b, b)), 1e-6) << i << j;
    }
  }
}

constexpr const char* kBlock = R"(
    <body pos="0.05 0 0"><joint name="block" type="slide" axis="1 0 0"/><joint type="slide"
      axis="0 0 1"/><joint name="turn" type="hinge" axis="0 1 0" pos="0 0 0.03"/>
      <geom type="box" size="0.02 0.1 0.02" mass="0.3" FRICTION/></body>
    <geom type="plane" pos="0 0 -0.0201" size="1 1 1" FRICTION/>)";

std::string block(const std::string& friction) {
  std::string text = kBlock;
  for (std::size_t at; (at = text.find("FRICTION")) != std::string::npos;) {
    text.replace(at, 8, friction);
  }
  return text;
}

/// The contact with the block after it came to rest on the floor, touched but not pushed.
client::Contact block_at_rest(const std::string& cone, const std::string& friction) {
  Still still(slider_model(block(friction), "cone=\"" + cone + '"'), {joint("x", 0)});
  still.world.m()->opt.gravity[2] = -9.81;
  still.settle();
  for (const NearContact& near : still.find()) {
    if (near.contact.mass > 0.0) return near.contact;
  }
  return {};
}

TEST(NearContacts, FloorDoesNotStiffenASlide) {
  for (const char* cone : {"elliptic", "pyramidal"}) {
    const client::Contact slides = block_at_rest(cone, R"(condim="1")");
    EXPECT_NEAR(slides.mass, 0.3, 0.03) << cone;
    EXPECT_LT(slides.ground_stiffness, 20.0) << cone;
    const client::Contact sticks = block_at_rest(cone, R"(condim="3" friction="1")");
    EXPECT_GT(sticks.damping, 10.0 * slides.damping + 10.0) << cone;
  }
}

TEST(NearContacts, ObjectsBehindGiveWayTogether) {
  // A block against a ball on a spring: 0.3 + 0.1 kg, and nearly 400 N/m.
  const std::string stiff = R"( solref="-40000 -100" solimp="0.5 0.5 0.001")";
  Still still(slider_model(R"(<body pos="0.0515 0 0"><joint type="slide" axis="1 0 0"/>
      <geom type="box" size="0.02 0.1 0.1" mass="0.3")" +
                           stiff + R"(/></body>
      <body pos="0.09 0 0"><joint type="slide" axis="1 0 0" stiffness="400" damping="1"/>
      <geom type="sphere" size="0.0199" mass="0.1")" +
                           stiff + "/></body>"),
              {joint("x", 0)});
  still.world.d()->qfrc_applied[1] = 1.0;
  still.settle();
  const auto found = still.find();
  const auto block = std::find_if(found.begin(), found.end(),
                                  [](const NearContact& near) { return near.contact.gap < 0.03; });
  ASSERT_NE(block, found.end());
  EXPECT_NEAR(block->contact.ground_stiffness, 400.0, 20.0);
  EXPECT_GT(block->contact.mass, 0.38);
  EXPECT_NEAR(block->contact.load, 0.0, 0.02) << "the ball's spring holds against 1 N";
}

TEST(NearContacts, SpringsOfTheToolGiveWay) {
  const std::string wall = kSoftWall;
  const std::string soft = R"(<mujoco><option timestep="0.001" gravity="0 0 0"/>
    <default><geom condim="1"/></default><worldbody>
    <body><joint name="x" type="slide" axis="1 0 0"/>
      <geom type="sphere" size="0.001" contype="0" conaffinity="0" mass="0.02"/>
      <body><joint type="slide" axis="1 0 0" stiffness="250"/>
        <geom type="sphere" size="0.01" mass="0.02"/></body></body>)" +
                           wall + "</worldbody></mujoco>";
  Still pad(soft, {joint("x", 0)});
  std::string stiff = soft;
  stiff.replace(stiff.find("250"), 3, "1e9");
  Still hard(stiff, {joint("x", 0)});
  const double series = pad.find().at(0).contact.stiffness;
  const double alone = hard.find().at(0).contact.stiffness;
  EXPECT_NEAR(1.0 / series - 1.0 / alone, 1.0 / 250.0, 1e-6);
}

TEST(NearContacts, IdsOutlastMotionAndAbsence) {
  Still still(R"(<mujoco><worldbody>
    <body name="tool" pos="0 0 0.02"><freejoint/><geom type="box" size="0.02 0.02 0.01"/></body>
    <body pos="0.1 0 0"><geom type="box" size="0.5 0.5 0.005"/></body>
    </worldbody></mujoco>)",
              {pose("tool", 0)});
  still.world.m()->geom_margin[0] = still.world.m()->geom_margin[1] = 0.02;
  using Corner = std::pair<bool, bool>;  // by the signs of x and y on the tool
  const auto corners_at = [&](double x, double z) {
    still.world.d()->qpos[0] = x;
    still.world.d()->qpos[2] = z;
    std::map<std::uint32_t, Corner> corners;
    for (const NearContact& near : still.find()) {
      const Vector3& at = near.contact.point.position;
      EXPECT_TRUE(corners.insert({near.contact.id, {at[0] > x, at[1] > 0.0}}).second);
    }
    return corners;
  };
  const auto first = corners_at(0.0, 0.01495);
  ASSERT_GE(first.size(), 4u);
  for (int i = 0; i < 50; ++i) {
    const auto moved = corners_at(0.002 * i, 0.01495 - 1e-5 * i);
    for (const auto& [id, corner] : first) {  // MuJoCo may find one corner twice
      ASSERT_TRUE(moved.contains(id));
      EXPECT_EQ(moved.at(id), corner);
    }
  }
  EXPECT_TRUE(corners_at(0.1, 0.2).empty());
  EXPECT_EQ(corners_at(0.1, 0.01495).begin()->first, 1u) << "an id comes back for its pair";
}

TEST(NearContacts, WhatBeginsInsideDoesNotCount) {
  Still still(slider_model(kSoftWall), {joint("x", 0)});
  still.world.d()->qpos[0] = 0.03;
  mj_forward(still.world.m(), still.world.d());
  still.contacts.begin(*still.world.m(), *still.world.d());
  EXPECT_TRUE(still.find().empty());
  still.world.d()->qpos[0] = 0.0199;
  EXPECT_EQ(still.find().size(), 1u) << "it was seen apart";
  still.world.d()->qpos[0] = 0.03;
  EXPECT_EQ(still.find().size(), 1u);
}

}  // namespace
}  // namespace haptic::mujoco
