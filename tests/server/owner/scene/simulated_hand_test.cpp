// The simulated hand behind scenes. Its closed loop: ScenePress, KinematicsScenes.
#include <numbers>

#include "hw/simulated/hand.hpp"
#include "tests/server/owner/scene/scene_run.hpp"
#include "tests/server/owner/scene/scene_text.hpp"

namespace haptic::test {
namespace {

using core::VecA;
using core::VecQ;

/// The shortest hand, on a palm. The source stands on line 4.
const std::string kHand = R"(name: "t"
device {
  name: "hand"
  simulated_hand {}
  tracked_hand { palm { position_lower_m: -0.5 position_upper_m: 0.5 }
    finger { name: "index" } output { name: "palm" frame {} }
    output { name: "tip" finger: "index" frame {} } }
  metric {}
  impedance { stiffness_n_per_m: 1500 }
  limits { force_n: 20 }
}
)";
std::string hand(const std::string& fields) {
  return replaced(kHand, "simulated_hand {}", "simulated_hand { " + fields + " }");
}

TEST(SimulatedHandScene, GivenValuesReachTheDevice) {
  const server::Scene scene =
      parse(hand("target: [0.1, 0.2, 0.3, 0, 0, 0, 0.4, 0.5] hand_stiffness: 0.7 noise_q_B_rad: 1 "
                 "actuator_force_limit_n: 30 arm { mass_kg: 2 rotation_damping: 0.5 }"));
  const auto& c = dynamic_cast<const hw::SimulatedHandConfig&>(*scene.devices[0].source);
  EXPECT_EQ(c.target[2], 0.3);
  EXPECT_EQ(c.target[7], 0.5);
  EXPECT_EQ(c.finger.hand_stiffness, 0.7);
  EXPECT_EQ(c.noise_q_B, 1.0);
  EXPECT_EQ(c.effort(), VecA::Constant(1, 30.0));
  EXPECT_EQ(c.arm.mass, 2.0);
  EXPECT_EQ(c.arm.rotation_damping, 0.5);
  EXPECT_EQ(c.arm.stiffness, hw::ArmParameters{}.stiffness);
  expect_resolved(scene, "rotation_stiffness: 5");
}

TEST(SimulatedHandScene, NamesEachMistake) {
  EXPECT_EQ(error_of(kHand), "no error");
  std::string no_palm = hand("arm {}");
  const std::size_t map = no_palm.find("tracked_hand"), metric = no_palm.find("  metric");
  no_palm.replace(map, metric - map, "hand_exoskeleton { finger { name: \"index\" } }\n");
  const std::string source = "device[0].simulated_hand.";
  expect_each_value_says({
      {kHand, source + "target=[0, 0, 0]", "must have one value per DoF, 8"},
      {kHand, source + "arm.mass_kg=0", "must be > 0"},
      {kHand, source + "arm.inertia_kg_m2=-1", "must be > 0"},
      {kHand, source + "arm.damping=-1", "must be >= 0"},
      {kHand, source + "hand_stiffness=0", "must be > 0"},
      {kHand, source + "noise_l_x_m=-1", "must be >= 0"},
  });
  expect_each_says({
      {"a palm outside its box", hand("target: [0, 0.6, 0, 0, 0, 0, 0, 0]"),
       "device[0].simulated_hand.target[1] = 0.6: must be within the palm's box, -0.5 to 0.5"},
      {"not a number", hand("target: [0, 0, 0, 0, 0, 0, nan, 0]"),
       "target[6] = nan: must be finite"},
      {"no spring", hand("arm { stiffness: 0 rotation_stiffness: 0 }"),
       "arm.rotation_stiffness = 0: must be > 0"},
      {"no such file", hand("motion_file: \"none.csv\""),
       "simulated_hand.motion_file = \"none.csv\": must be a CSV file"},
      {"too weak", hand("actuator_force_limit_n: 10"),
       "device[0].limits.force_n[0] = 20: must be at most what the device can give, 10"},
      {"an arm without a palm", no_palm,
       "simulated_hand.arm = { ... } with a palm that stands still: must go with tracked_hand"},
      {"a hand on a finger", replaced(kFinger, "simulated_finger", "simulated_hand"),
       "t.textproto:4: device[0].simulated_hand = { ... } with finger_exoskeleton: must go with "
       "hand_exoskeleton or tracked_hand"},
  });
}

TEST(SimulatedHandScene, ShippedHandsRestAtThirtyDegrees) {
  for (const char* name : {"hand_five_fingers", "hand_tracked_palm"}) {
    const server::Scene scene = shipped_scene(name);
    const VecQ q = rest_of(scene.devices[0]);
    core::VecX x;
    core::MatXQ J;
    for (const core::Mechanism& finger : scene.devices[0].pipeline.kinematics->mechanisms()) {
      ASSERT_EQ(finger.kinematics->evaluate(q.segment(finger.first_q, 2), x, J),
                core::MapStatus::kOk);
      EXPECT_LT((x.array() - std::numbers::pi / 6.0).abs().maxCoeff(), 0.001) << name;
    }
  }
}

}  // namespace
}  // namespace haptic::test
