/// How objects move that stand in a pile: what counts, and that it is all that counts.

#include "pushed_object.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/mujoco/mujoco_world.hpp"

namespace haptic::mujoco {
namespace {

std::string box(const char* name, const char* position) {
  return std::string(R"(<body name=")") + name + R"(" pos=")" + position +
         R"("><freejoint/><geom type="box" size="0.02 0.02 0.02" mass="0.1"/></body>)";
}

/// Two boxes one on the other, `others`, and a tool that touches nothing.
struct Pile {
  explicit Pile(const std::string& others = "", const std::string& option = "",
                const std::string& equality = "")
      : world("<mujoco><option " + option + R"(/><worldbody><geom type="plane" size="1 1 1"/>
          <body pos="0 0 0.5"><joint name="x" type="slide" axis="1 0 0"/>
            <geom type="sphere" size="0.01"/></body>)" +
              box("low", "0 0 0.0199") + box("high", "0.01 0 0.0597") + others +
              "</worldbody><equality>" + equality + "</equality></mujoco>"),
        tool((mj_forward(world.m(), world.d()), *world.m()), *world.d(), {joint("x", 0)},
             {.coupling = 1.0}),
        surroundings(tool) {}
  std::size_t dofs(std::initializer_list<const char*> touched) {
    std::set<int> bodies;
    for (const char* name : touched) bodies.insert(world.id(mjOBJ_BODY, name));
    const std::vector<mjtNum> rate(static_cast<std::size_t>(world.m()->nv), 0.0);
    surroundings.look(*world.m(), *world.d(), rate, bodies);
    return surroundings.dofs();
  }
  client::Contact law(const char* name) {
    const int body = world.id(mjOBJ_BODY, name);
    const mjtNum* at = world.d()->xpos + 3 * body;
    client::Contact told{.normal = {-1.0, 0.0, 0.0}};
    static_cast<void>(surroundings.object(*world.m(), *world.d(), body,
                                          {at[0] - 0.02, at[1], at[2] + 0.01}, 0.0, told));
    return told;
  }
  World world;
  BoundTool tool;
  Surroundings surroundings;
};

const std::string kOthers =
    box("alone", "0.3 0 0.0199") + box("tied", "0.5 0 0.0199") + box("to", "0.7 0 0.3");
constexpr const char* kTie = R"(<connect body1="tied" body2="to" anchor="0.1 0 0"/>)";

TEST(PushedObject, OnlyWhatIsConnectedCounts) {
  for (const char* jacobian : {R"(jacobian="dense")", R"(jacobian="sparse")"}) {
    Pile pile(kOthers, jacobian, kTie);
    EXPECT_EQ(pile.dofs({}), 0u);
    EXPECT_EQ(pile.dofs({"world"}), 0u);
    EXPECT_EQ(pile.law("low").mass, 0.0);
    EXPECT_EQ(pile.dofs({"alone"}), 6u);
    EXPECT_EQ(pile.dofs({"high"}), 12u);
    EXPECT_EQ(pile.dofs({"low", "world"}), 12u);
    EXPECT_EQ(pile.dofs({"to"}), 12u) << "an equality connects too";
    EXPECT_EQ(pile.dofs({"to", "low", "alone"}), 30u);
  }
}

void expect_same(const client::Contact& a, const client::Contact& b) {
  EXPECT_GT(a.mass, 0.01);
  EXPECT_NEAR(a.mass, b.mass, 1e-9 * a.mass);
  EXPECT_NEAR(a.damping, b.damping, 1e-9 * a.damping);
  EXPECT_NEAR(a.ground_stiffness, b.ground_stiffness, 1e-9 * a.ground_stiffness);
  EXPECT_NEAR(a.load, b.load, 1e-9);
}

TEST(PushedObject, WhatStandsApartChangesNothing) {
  for (const std::string cone : {R"(cone="elliptic")", R"(cone="pyramidal")"}) {
    Pile alone("", cone + R"( jacobian="dense")");
    Pile dense(kOthers, cone + R"( jacobian="dense")", kTie);
    Pile sparse(kOthers, cone + R"( jacobian="sparse")", kTie);
    for (const char* name : {"low", "high"}) {
      SCOPED_TRACE(cone + name);
      for (Pile* pile : {&alone, &dense}) static_cast<void>(pile->dofs({"low", "high"}));
      static_cast<void>(sparse.dofs({"to", "high", "alone"}));
      expect_same(alone.law(name), dense.law(name));
      expect_same(alone.law(name), sparse.law(name));
    }
    EXPECT_GT(alone.law("low").damping, 10.0) << "the floor and the other box hold it";
  }
}

TEST(Skyline, SolvesWhatWasAdded) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (const std::size_t n : {1u, 2u, 7u, 40u}) {
    Skyline matrix;
    std::vector<double> dense(n * n), x(n);
    matrix.begin(n);
    for (std::size_t i = 0; i < n; ++i) {
      if (i % 3 != 0) matrix.reach(i, i / 2);
    }
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = i % 3 != 0 ? i / 2 : i; k <= i; ++k) {
        const double value = k == i ? 2.0 * static_cast<double>(n) : uniform(random);
        matrix.add(i, k, value);
        dense[i * n + k] = dense[k * n + i] = value;
      }
      x[i] = uniform(random);
    }
    const std::vector<double> right = x;
    matrix.factor();
    matrix.solve(x);
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_NEAR(mju_dot(&dense[i * n], x.data(), static_cast<int>(n)), right[i], 1e-12);
    }
  }
}

}  // namespace
}  // namespace haptic::mujoco
