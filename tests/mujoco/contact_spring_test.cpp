/// The spring of a MuJoCo contact against MuJoCo: a ball pressed on a wall until it rests.

#include "haptic/mujoco/contact_spring.hpp"

#include <gtest/gtest.h>

#include "tests/mujoco/mujoco_world.hpp"

namespace haptic::mujoco {
namespace {

constexpr const char* kParameters[] = {
    R"(solref="-5000 -50" solimp="0.5 0.5 0.001")", R"(solref="-2000 -100" solimp="0.1 0.6 0.004")",
    R"(solref="0.02 1")", R"(solref="0.05 0.7" solimp="0.3 0.9 0.002 0.3 3")",
    R"(solref="0.0001 1" solimp="0.2 0.8 0.01")"};

/// Penetration, m, and MuJoCo's force, N, at rest under `push` N.
std::pair<double, double> pressed(World& world, double push) {
  world.d()->qpos[0] = 0.0195;
  for (int i = 0; i < 100000 && (i < 100 || std::abs(world.d()->qvel[0]) > 1e-8); ++i) {
    world.d()->qfrc_applied[0] = push - 5.0 * world.d()->qvel[0];
    mj_step(world.m(), world.d());
  }
  mjtNum force[6] = {};
  if (world.d()->ncon == 1) mj_contactForce(world.m(), world.d(), 0, force);
  return {world.d()->contact[0].includemargin - world.d()->contact[0].dist, force[0]};
}

TEST(ContactSpring, RestingForceIsMujocos) {
  for (const char* cone : {"elliptic", "pyramidal"}) {
    for (const char* friction : {R"(condim="1")", R"(condim="3" friction="0.4")",
                                 R"(condim="4" friction="1.2 0.01 0.001")"}) {
      for (const char* parameters : kParameters) {
        SCOPED_TRACE(std::string(cone) + ' ' + friction + ' ' + parameters);
        World world(slider_model(
            R"(<geom type="plane" pos="0.03 0 0" zaxis="-1 0 0" size="1 1 1" priority="1" )" +
                std::string(friction) + ' ' + parameters + "/>",
            std::string("cone=\"") + cone + '"'));
        for (const double push : {0.2, 1.0}) {
          const auto [depth, force] = pressed(world, push);
          ASSERT_EQ(world.d()->ncon, 1);
          EXPECT_NEAR(force, push, 1e-3 * push);
          const ContactSpring spring(*world.m(), world.d()->contact[0]);
          EXPECT_NEAR(spring.force(depth), force, 2e-3 * force);
        }
      }
    }
  }
}

TEST(ContactSpring, SlopeIsTheForcesDifference) {
  for (const char* parameters : kParameters) {
    SCOPED_TRACE(parameters);
    World world(slider_model(
        R"(<geom type="plane" pos="0.03 0 0" zaxis="-1 0 0" size="1 1 1" priority="1" )" +
        std::string(parameters) + "/>"));
    static_cast<void>(pressed(world, 1.0));
    const ContactSpring spring(*world.m(), world.d()->contact[0]);
    for (const double depth : {1e-4, 7e-4, 3e-3, 2e-2}) {
      const double h = 1e-9;
      const double difference = (spring.force(depth + h) - spring.force(depth - h)) / (2.0 * h);
      EXPECT_NEAR(spring.slope(depth), difference, 1e-3 * difference) << depth;
      EXPECT_EQ(spring.stiffness(depth), spring.slope(depth));
    }
    EXPECT_GT(spring.stiffness(-1.0), 0.0);
    EXPECT_EQ(spring.force(-1e-3), 0.0);
  }
}

}  // namespace
}  // namespace haptic::mujoco
