#include "tests/server/owner/scene/scene_text.hpp"

namespace haptic::test {
namespace {

/// A device with this kinematics; it starts on line 5.
std::string device_with(const std::string& kinematics) {
  return "name: \"t\"\ndevice {\n  name: \"d\"\n"
         "  simulated_linear { mass: [1, 1] max_effort: [5] }\n  " +
         kinematics + "\n  impedance { stiffness_n_per_m: [5] }\n  limits { force_n: [2] }\n}\n";
}

/// Calls expect_each_says() with each row's kinematics in a device.
void expect_each_map_says(std::vector<BadScene> table) {
  for (BadScene& bad : table) bad.text = device_with(bad.text);
  expect_each_says(table);
}

const std::string kPoint = " output { name: \"tip\" point { position_m: [0.1, 0.2, 0.3] } }";

TEST(KinematicsErrors, ChainNamesPlaceAndRule) {
  const auto chain = [](const std::string& joints) {
    return "serial_chain { " + joints + kPoint + " }";
  };
  const std::string a =
      "joint { name: \"a\" kind: \"prismatic\" actuated: true lower: -1 upper: 1 } ";
  const std::string b = "joint { name: \"b\" lower: -1 upper: 1 ";
  EXPECT_EQ(error_of(device_with(chain(a + b + "}"))), "no error");
  expect_each_map_says({
      {"no joint", chain(""), "t.textproto:5: device[0].serial_chain.joint: is required"},
      {"no output", "serial_chain { " + a + " }",
       "t.textproto:5: device[0].serial_chain.output: is required: at least one"},
      {"kind", chain(a + b + "kind: \"screw\" }"),
       "device[0].serial_chain.joint[1].kind = \"screw\": must be \"revolute\" or \"prismatic\""},
      {"limits", chain("joint { name: \"a\" actuated: true }"),
       "device[0].serial_chain.joint[0].upper = 0: must be above lower, 0"},
      {"name", chain(a + a), "joint[1].name = \"a\": must be another: this one is taken"},
      {"name with a dot", chain(a + "joint { name: \"b.c\" upper: 1 }"),
       "joint[1].name = \"b.c\": must be 1 to 24 of letters, digits, _ and -"},
      {"the base's name", chain(a + "joint { name: \"base\" upper: 1 }"),
       "device[0].serial_chain = { ... }: joint base: the name is taken by the fixed frame"},
      {"axis", chain(a + b + "axis: [0, 1] }"),
       "joint[1].axis = [0, 1]: must have one value per axis, 3"},
      {"orientation", chain(a + b + "origin { orientation: [0, 0, 0, 0] } }"),
       "joint[1].origin.orientation = [0, 0, 0, 0]: must be a quaternion other than zero"},
      {"position", chain(a + b + "origin { position_m: [0, nan, 0] } }"),
       "joint[1].origin.position_m[1] = nan: must be finite"},
      {"neither point nor frame", "serial_chain { " + a + b + "} output { name: \"tip\" } }",
       "device[0].serial_chain.output[0].what: is required: one of point, frame"},
      {"a frame without W", "serial_chain { " + a + b + "} output { name: \"tip\" frame {} } }",
       "device[0].metric: is required: x holds metres and radians"},
      {"nothing actuated", chain(b + "}"), "device without an actuated DoF"},
      {"palm", chain("palm { position_lower_m: 2 } " + a),
       "palm.position_upper_m = 1: must be above its lower limit, 2"},
  });
}

TEST(KinematicsErrors, StylusNamesPlaceAndRule) {
  expect_each_map_says({
      {"length", "stylus { forearm_m: 0" + kPoint + " }",
       "t.textproto:5: device[0].stylus.forearm_m = 0: must be > 0"},
      {"limits", "stylus { elbow_upper_rad: -3" + kPoint + " }",
       "device[0].stylus = { ... }: joint elbow from -2.400000 to -3.000000"},
      {"no output", "stylus {}", "device[0].stylus.output: is required: at least one"},
      {"masses", "stylus {" + kPoint + " }",
       "device[0].simulated_linear.mass = [1, 1]: must have one value per DoF, 6"},
  });
}

TEST(KinematicsErrors, HandNamesPlaceAndRule) {
  const std::string finger = " finger { name: \"a\" } ";
  EXPECT_EQ(error_of(device_with("hand_exoskeleton {" + finger + "}")), "no error");
  expect_each_map_says({
      {"no finger", "hand_exoskeleton {}",
       "t.textproto:5: device[0].hand_exoskeleton.finger: is required: 1 to 12"},
      {"size", "hand_exoskeleton { finger { name: \"a\" size: 0 } }",
       "device[0].hand_exoskeleton.finger[0].size = 0: must be > 0"},
      {"dimension", "hand_exoskeleton { finger { name: \"a\" dimensions { rod1_m: -1 } } }",
       "finger[0].dimensions.rod1_m = -1: must be > 0"},
      {"closes nowhere",
       "hand_exoskeleton { finger { name: \"a\" dimensions { rod1_m: 0.5 rod2_m: 0.5 } } }",
       "device[0].hand_exoskeleton = { ... }: finger a: "},
      {"tracked: no finger", "tracked_hand {" + kPoint + " }",
       "device[0].tracked_hand.finger: is required: 1 to 9"},
      {"tracked: no output", "tracked_hand {" + finger + "}",
       "device[0].tracked_hand.output: is required: at least one"},
      {"phalanx",
       "tracked_hand {" + finger + "output { name: \"t\" finger: \"a\" phalanx: \"x\" point {} } }",
       "output[0].phalanx = \"x\": must be \"proximal\" or \"middle\""},
      {"mount",
       "tracked_hand { finger { name: \"a\" mount { orientation: [1, 0, 0] } }" + kPoint + " }",
       "finger[0].mount.orientation = [1, 0, 0]: must have one value per part x, y, z, w, 4"},
  });
}

}  // namespace
}  // namespace haptic::test
