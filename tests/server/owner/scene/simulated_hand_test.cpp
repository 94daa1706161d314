// The simulated hand behind scenes: wrong scenes, and the closed loop over the whole hand.
#include <cmath>
#include <numbers>

#include "hw/simulated/hand.hpp"
#include "tests/server/owner/scene/scene_run.hpp"
#include "tests/server/owner/scene/scene_text.hpp"
#include "tests/support/temporary_file.hpp"

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
  expect_each_says({
      {"target", hand("target: [0, 0, 0]"),
       "t.textproto:4: device[0].simulated_hand.target = [0, "
       "0, 0]: must have one value per DoF, 8"},
      {"a palm outside its box", hand("target: [0, 0.6, 0, 0, 0, 0, 0, 0]"),
       "device[0].simulated_hand.target[1] = 0.6: must be within the palm's box, -0.5 to 0.5"},
      {"not a number", hand("target: [0, 0, 0, 0, 0, 0, nan, 0]"),
       "target[6] = nan: must be finite"},
      {"no mass", hand("arm { mass_kg: 0 }"), "simulated_hand.arm.mass_kg = 0: must be > 0"},
      {"no inertia", hand("arm { inertia_kg_m2: -1 }"), "arm.inertia_kg_m2 = -1: must be > 0"},
      {"a damper that drives", hand("arm { damping: -1 }"), "arm.damping = -1: must be >= 0"},
      {"no spring", hand("arm { stiffness: 0 rotation_stiffness: 0 }"),
       "arm.rotation_stiffness = 0: must be > 0"},
      {"no hand", hand("hand_stiffness: 0"), "simulated_hand.hand_stiffness = 0: must be > 0"},
      {"noise", hand("noise_l_x_m: -1"), "simulated_hand.noise_l_x_m = -1: must be >= 0"},
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

const core::Mechanism& finger_of(const core::Kinematics& hand, int i) {
  return hand.mechanisms()[static_cast<std::size_t>(i)];
}

/// The joint angles of finger i.
core::VecX joints_of(const core::Kinematics& hand, const VecQ& q, int i) {
  core::VecX x;
  core::MatXQ J;
  const core::Mechanism& finger = finger_of(hand, i);
  EXPECT_EQ(finger.kinematics->evaluate(q.segment(finger.first_q, 2), x, J), core::MapStatus::kOk);
  return x;
}

/// q with every joint of every finger at most `stop`.
VecQ stopped(const core::Kinematics& hand, const VecQ& q, double stop) {
  VecQ at = q;
  for (int i = 0; i < hand.layout().n_a(); ++i) {
    const core::VecX x = joints_of(hand, q, i).cwiseMin(stop);
    const core::Mechanism& finger = finger_of(hand, i);
    VecQ inverse;
    EXPECT_EQ(finger.kinematics->inverse(x, inverse), core::InverseStatus::kExact);
    at.segment<2>(finger.first_q) = inverse;
  }
  return at;
}

class HandScenes : public testing::TestWithParam<const char*> {
 protected:
  server::Scene scene = server::load_scene(kScenes / (std::string(GetParam()) + ".textproto"));
  const server::DeviceScene& device = scene.devices.front();
  const core::Kinematics& kinematics = *device.pipeline.kinematics;
};

TEST_P(HandScenes, HoldTheirJointsAtThirtyDegrees) {
  const VecQ q = rest_of(device);
  for (int i = 0; i < 5; ++i) {
    EXPECT_LT((joints_of(kinematics, q, i).array() - std::numbers::pi / 6.0).abs().maxCoeff(),
              0.001);
  }
}

TEST_P(HandScenes, AreGuardedAndHaveATank) {
  EXPECT_TRUE(device.pipeline.scene.direction_guard);
  EXPECT_TRUE(device.pipeline.passivity.tank.enabled);
  EXPECT_EQ(device.pipeline.passivity.device_damping, VecA::Constant(5, 2.0));
}

/// An object keeps every joint from flexing beyond 20 degrees: every finger gives way until its
/// hand holds the force, K_h (30 deg - x) = -w tau_a, and the palm stays.
TEST_P(HandScenes, EveryFingerGivesWay) {
  SceneRun run(device);
  run.free();
  run.engage();
  run.run(3000);
  const VecQ before = run.record().sensed.q;
  run.hold(stopped(kinematics, before, 20.0 * std::numbers::pi / 180.0));
  run.run(3000);
  const core::TickRecord& record = run.record();
  for (int i = 0; i < 5; ++i) {
    const core::VecX x = joints_of(kinematics, record.sensed.q, i);
    const double tau = record.effort.tau_a[i];
    EXPECT_LT(tau, -1.0) << i;
    core::VecX beyond = x;
    VecQ q, q_beyond;
    for (int j = 0; j < 2; ++j) {
      beyond = x;
      beyond[j] += 1e-6;
      ASSERT_EQ(finger_of(kinematics, i).kinematics->inverse(x, q), core::InverseStatus::kExact);
      ASSERT_EQ(finger_of(kinematics, i).kinematics->inverse(beyond, q_beyond),
                core::InverseStatus::kExact);
      const double w = (q_beyond[0] - q[0]) / 1e-6;
      EXPECT_NEAR(0.6 * (x[j] - 0.524), w * tau, 1e-4) << i;
    }
    EXPECT_LT(x.sum(), joints_of(kinematics, before, i).sum() - 0.02) << i;
  }
  if (GetParam() == std::string("hand_tracked_palm")) {
    EXPECT_EQ(record.sensed.q.head<6>(), before.head<6>());
  }
}

/// All fingers flex and extend while a palm moves; 60 samples a second keep the joints from flexing
/// beyond 30 degrees. What the fingers give way by is seen, and the energy stays within the tank.
TEST_P(HandScenes, GraspsAreFeltAndPassive) {
  const bool on_a_palm = GetParam() == std::string("hand_tracked_palm");
  std::string csv = "time_s";
  for (const char* finger : {"thumb", "index", "middle", "ring", "little"}) {
    csv += std::string(",") + finger + ".q_o1_mcp_rad," + finger + ".q_o2_pip_rad";
  }
  csv += on_a_palm ? ",palm.x,palm.y,palm.z\n" : "\n";
  for (int row = 0; row <= 60; ++row) {
    const double flexion = 0.5 - 0.4 * std::cos(0.05 * row * 2.0 * std::numbers::pi);
    csv += std::to_string(0.05 * row);
    for (int i = 0; i < 10; ++i) csv += "," + std::to_string(flexion);
    csv += on_a_palm ? "," + std::to_string(0.2 * flexion) + ",0,0.1\n" : "\n";
  }
  const TemporaryFile file(csv);
  hw::SimulatedHandConfig moving = dynamic_cast<const hw::SimulatedHandConfig&>(*device.source);
  moving.motion_file = file.path();
  const double stop = std::numbers::pi / 6.0;

  SceneRun run(device, moving);
  run.free();
  run.engage();
  const core::DofLayout& layout = kinematics.layout();
  const VecA b = device.pipeline.passivity.device_damping;
  VecA held = VecA::Zero(5), q_a = layout.select(run.record().sensed.q);
  VecA deepest = VecA::Zero(5), strongest = VecA::Zero(5);
  double given = 0.0, most_given = 0.0;
  for (int frame = 0; frame < 600; ++frame) {
    const VecQ q = run.record().sensed.q;
    bool touches = false;
    for (int i = 0; i < 5; ++i) touches |= joints_of(kinematics, q, i).maxCoeff() > stop;
    touches ? run.hold(stopped(kinematics, q, stop)) : run.free();
    for (int tick = 0; tick < 10; ++tick) {
      const core::TickRecord& record = run.tick();
      ASSERT_FALSE(record.faults().any());
      ASSERT_EQ(record.life.state, core::LifecycleState::kEngaged);
      const VecA dq = layout.select(record.sensed.q) - q_a;
      q_a += dq;
      given += held.dot(dq) - dq.dot(b.cwiseProduct(dq)) / 1e-3;
      most_given = std::max(most_given, given);
      held = record.effort.tau_a;
      strongest = strongest.cwiseMin(held);
      for (int i = 0; i < 5; ++i) {
        deepest[i] = std::max(deepest[i], joints_of(kinematics, record.sensed.q, i).maxCoeff());
      }
    }
  }
  EXPECT_LE(most_given, device.pipeline.passivity.tank.initial + 1e-6);
  EXPECT_LT(strongest.maxCoeff(), -2.0) << "felt by every finger";
  EXPECT_LT(deepest.maxCoeff(), 0.88) << "free, it would flex to 0.9 rad";
}

INSTANTIATE_TEST_SUITE_P(Shipped, HandScenes,
                         testing::Values("hand_five_fingers", "hand_tracked_palm"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace haptic::test
