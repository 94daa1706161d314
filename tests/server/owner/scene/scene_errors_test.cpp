#include <gmock/gmock.h>

#include <algorithm>

#include "tests/server/owner/scene/scene_text.hpp"

namespace haptic::test {
namespace {

std::string finger(const std::string& from, const std::string& to) {
  return replaced(kFinger, from, to);
}
std::string linear(const std::string& from, const std::string& to) {
  return replaced(kLinear, from, to);
}

TEST(SceneErrors, TextNamesPlaceAndRule) {
  expect_each_says({
      {"unknown field", finger("stiffness_n_per_m", "stifness_n_per_m"),
       "t.textproto:7:5: stifness_n_per_m: unknown field; allowed here: stiffness_n_per_m, "
       "stiffness_matrix, damping_n_s_per_m"},
      {"value on the next line", finger("1500", "1500\n    damping:\n 3"),
       "t.textproto:8:5: damping: unknown field; allowed here: damping_n_s_per_m, "},
      {"unknown in a message without fields", finger("limits {", "standard { k: 1 }\n limits {"),
       "t.textproto:9:14: k: unknown field; allowed here: no fields"},
      {"syntax", finger("limits {", "limits ("), "t.textproto:9:10: "},
      {"wrong type", finger("1500", "\"much\""), "t.textproto:7:24: Expected double"},
      {"twice", finger("name: \"finger\"", "name: \"a\" name: \"b\""), "t.textproto:3:"},
      {"two sources", finger("simulated_finger {}", "simulated_finger {} replay {}"),
       "t.textproto:4:"},
      {"unfinished", kFinger.substr(0, kFinger.size() - 3),
       "t.textproto:9:25: a } is missing, for the { of line 2 or for one within it"},
      {"unfinished list", "name: \"t\"\nserver { listen: [\"a:1\"\n",
       "t.textproto:3:1: a ] is missing, for the [ of line 2 or for one within it"},
      {"unfinished within", finger("1500\n  }", "1500"),
       ": a } is missing, for the { of line 2 or for one within it"},
      {"not a scene at all",
       "\x7f"
       "ELF",
       "t.textproto:1:"},
      {"nested without end",
       [] {
         std::string text;
         for (int i = 0; i < 100000; ++i) text += "a{";
         return text;
       }(),
       "t.textproto: its messages are nested too deeply"},
      {"huge", std::string(2 << 20, ' '), "t.textproto: has more than 262144 bytes"},
  });
}

TEST(SceneErrors, CommentsDoNotNest) {
  EXPECT_EQ(error_of("# " + std::string(100, '{') + "\n" +
                     replaced(kFinger, "\"t\"", "\"" + std::string(60, '{') + "\"")),
            "no error");
}

TEST(SceneErrors, DeviceNamesPlaceAndRule) {
  expect_each_says({
      {"no device", "name: \"t\"\n", "t.textproto: device: is required: at least one"},
      {"no name", replaced(kFinger, "name: \"t\"\n", ""), "t.textproto: name: is required"},
      {"long name", finger("\"t\"", "\"" + std::string(65, 'a') + "\""),
       "must be 1 to 64 characters on one line"},
      {"two lines", finger("\"t\"", "\"a\\nb\""),
       "t.textproto:1: name = \"a\\nb\": must be 1 to 64 characters on one line"},
      {"bad device name", finger("\"finger\"", "\"My Finger\""),
       "t.textproto:3: device[0].name = \"My Finger\": must be 1 to 32 of [a-z0-9_-]"},
      {"no device name", finger("name: \"finger\"", ""), "t.textproto:2: device[0].name = \"\""},
      {"twice the same name", kFinger + kFinger.substr(kFinger.find("device")),
       "t.textproto:12: device[1].name = \"finger\": must be another"},
      {"no source", finger("simulated_finger {}", ""),
       "t.textproto:2: device[0].source: is required: one of simulated_finger, simulated_linear, "
       "replay, board"},
      {"a board without a port", finger("simulated_finger {}", "board { max_effort: 40 }"),
       "t.textproto:4: device[0].board.port: is required"},
      {"a board without limits", finger("simulated_finger {}", "board { port: \"/dev/ttyACM0\" }"),
       "device[0].board.max_effort"},
      {"more force than the board can give",
       finger("simulated_finger {}", "board { port: \"/dev/ttyACM0\" max_effort: 19 }"),
       "device[0].limits.force_n[0] = 20: must be at most what the device can give, 19"},
      {"no kinematics", finger("finger_exoskeleton {}", ""),
       "t.textproto:2: device[0].kinematics: is required: one of finger_exoskeleton, linear"},
      {"no impedance", finger("impedance {\n    stiffness_n_per_m: 1500\n  }", ""),
       "t.textproto:2: device[0].impedance: is required"},
      {"no limits", finger("limits { force_n: 20 }", ""),
       "t.textproto:2: device[0].limits: is required"},
      {"a finger on a linear map",
       linear("simulated_linear { mass: [1, 2] max_effort: 5 }", "simulated_finger {}"),
       "t.textproto:4: device[0].simulated_finger = { ... } with linear: must go with "
       "finger_exoskeleton"},
      {"masses on a finger",
       finger("simulated_finger {}", "simulated_linear { mass: [1, 2] max_effort: 40 }"),
       "t.textproto:4: device[0].simulated_linear = { ... } with finger_exoskeleton: must go with "
       "another kinematics"},
  });
}

TEST(SceneErrors, LimitsNamePlaceAndRule) {
  expect_each_says({
      {"negative", finger("1500", "-3"),
       "t.textproto:7: device[0].impedance.stiffness_n_per_m[0] = -3: must be > 0"},
      {"missing", finger("stiffness_n_per_m: 1500", ""),
       "t.textproto:6: device[0].impedance.stiffness_n_per_m: is required: one value per actuated "
       "DoF, 1"},
  });
}

TEST(SceneErrors, ValuesNameFieldAndRule) {
  const std::string d = "device[0].", address = "must be \"host:port\"";
  expect_each_value_says({
      {kFinger, d + "impedance.stiffness_n_per_m[0]=0", "must be > 0"},
      {kFinger, d + "impedance.stiffness_n_per_m[0]=inf", "must be finite and > 0"},
      {kFinger, d + "impedance.damping_n_s_per_m[0]=-0.1", "must be >= 0"},
      {kFinger, d + "impedance.stiffness_n_per_m[0]=nan", "must be finite and > 0"},
      {kLinear, d + "impedance.stiffness_n_per_m=[5, 6]",
       "must have one value per actuated DoF, 1"},
      {kFinger, d + "staleness.fresh_end={nanos: 110000000}",
       " = 110 ms: must be at most hold_end, 100 ms"},
      {kFinger, d + "staleness.fade_end={nanos: 149000000}",
       " = 149 ms: must be at least hold_end + 50 ms, 150 ms"},
      {kFinger, d + "staleness.fade_end={seconds: 2}",
       " = 2000 ms: must be at most hold_end + 1000 ms, 1100 ms"},
      {kFinger, d + "staleness.hold_end={seconds: 1 nanos: -1}",
       " = { seconds: 1 nanos: -1 }: must be 1 ms to 60000 ms"},
      {kFinger, "server.lease_timeout={nanos: 499000000}", " = 499 ms: must be 500 ms to 60000 ms"},
      {kFinger, "server.lease_timeout={seconds: 9223372036854775807}",
       " = { seconds: 9223372036854775807 nanos: 0 }: must be 500 ms"},
      {kFinger, "loop.period={nanos: 499999}", " = 0.499999 ms: must be 0.5 ms to 10 ms"},
      {kFinger, "loop.loop_late_fault={nanos: 1000000}", " = 1 ms: must be above the period, 1 ms"},
      {kFinger, d + "limits.force_n[0]=41", "must be at most what the device can give, 40"},
      {kFinger, d + "limits.slew_n_per_s[0]=0", "must be > 0"},
      {kFinger, d + "limits.engage_window_n[0]=-1", "must be > 0"},
      {kFinger, d + "simulated_finger.hand_stiffness=-1", "must be > 0"},
      {kFinger, d + "simulated_finger.noise_q_B_rad=nan", "must be finite and >= 0"},
      {kFinger, d + "simulated_finger.actuator_mass_kg=0", "must be > 0"},
      {kFinger, d + "finger_exoskeleton.rod1_m=-1", "must be > 0"},
      {kFinger, d + "finger_exoskeleton.linkage=\"finger\"",
       "must be \"finger_same_sign\" or \"finger_sign_change\""},
      {kFinger, d + "finger_exoskeleton.slider1_upper_m=0.001",
       "must be above its lower limit, 0.004"},
      {kBoard, d + "board.baud=300", "must be 9600 to 12000000"},
      {kLinear, d + "simulated_linear.mass[1]=0", "must be > 0"},
      {kLinear, d + "simulated_linear.mass=[1]", "must have one value per DoF, 2"},
      {kLinear, d + "linear.A=[1, 0.5, 3]", "must have one value per DoF and coordinate, 2"},
      {kLinear, d + "linear.A[1]=inf", "must be finite"},
      {kLinear, d + "linear.x_0=[0, 0]", "must have one value per coordinate, 1"},
      {kLinear, d + "linear.dof[1].unit=\"deg\"", "must be \"m\" or \"rad\""},
      {kLinear, d + "linear.dof[1].upper=-2", "must be finite and above lower, -2"},
      {kLinear, d + "linear.dof[1].name=\"s\"", "must be another"},
      {kLinear, d + "linear.dof[1].name=\"r,s\"", "must be 1 to 32 of letters, digits, _ and -"},
      {kLinear, d + "linear.coordinate[0].full_circle=true", "must be a coordinate in \"rad\""},
      {kLinear, d + "metric.scale_m=0", "must be > 0"},
      {kLinear, d + "metric.W=[1, 0]", "must have one value per pair of coordinates, 1"},
      {kLinear, d + "prior.weight=0", "must be finite and > 0"},
      {kLinear, d + "prior.sensed_stiffness=[3, 3]", "must have one value per sensed DoF, 1"},
      {kFinger, "server.udp_listen=\"unix:/run/h\"", address.c_str()},
      {kFinger, "server.udp_listen=\"127.0.0.1\"", address.c_str()},
      {kFinger, "server.metrics_listen=\"127.0.0.1\"", address.c_str()},
      {kFinger, "server.max_sessions=257", "must be 1 to 256"},
      {kFinger, "server.max_sessions=0", "must be 1 to 256"},
      {kFinger, "loop.priority=99", "must be 1 to 98"},
      {kFinger, "loop.cpu=-1", "must be 0 to 1023"},
      {kFinger, "loop.late_bucket_full=9", "must be 10 to 1000000"},
      {kFinger, "record.file=\"a.txt\"", "must end in \".csv\""},
  });
}

TEST(SceneErrors, LimitsMustFitEachOther) {
  const std::string hold = "device[0].staleness.hold_end=", fade = "device[0].staleness.fade_end=";
  expect_says(kFinger, "fade_end = 180 ms: must be at least hold_end + 50 ms, 190 ms",
              {hold + "{nanos: 140000000}"});
  expect_says(kFinger, "fade_end = 2500 ms: must be at most server.lease_timeout, 2000 ms",
              {hold + "{seconds: 2}", fade + "{seconds: 2 nanos: 500000000}"});
}

TEST(SceneErrors, SourceNamesPlaceAndRule) {
  expect_each_says({
      {"no such recording",
       finger("simulated_finger {}", "simulated_finger { motion_file: \"no.csv\" }"),
       "t.textproto:4: device[0].simulated_finger.motion_file = \"no.csv\": must be a CSV file; "
       "there is none at " +
           (kScenes / "no.csv").string()},
      {"recording and target",
       finger("simulated_finger {}",
              "simulated_finger { motion_file: \"motion/reach_and_grasp.csv\" target_mcp_rad: 1 }"),
       "must be one or the other"},
      {"no mass", linear("mass: [1, 2]", ""),
       "device[0].simulated_linear.mass: is required: one value per DoF, 2"},
      {"damping", linear("mass:", "damping: [0, -1] mass:"),
       "device[0].simulated_linear.damping[1] = -1: must be >= 0"},
      {"effort", linear(" max_effort: 5", ""),
       "device[0].simulated_linear.max_effort: is required: one value per actuated DoF, 1"},
      {"replay of nothing", finger("simulated_finger {}", "replay { max_effort: 40 }"),
       "t.textproto:4: device[0].replay.file: is required: a CSV file"},
      {"replay without effort",
       finger("simulated_finger {}", "replay { file: \"motion/reach_and_grasp.csv\" }"),
       "t.textproto:4: device[0].replay.max_effort: is required: one value per actuated DoF, 1"},
  });
}

TEST(SceneErrors, LinearMapNamesPlaceAndRule) {
  const std::string finger_map = "finger_exoskeleton {}";
  expect_each_says({
      {"closes nowhere", finger(finger_map, "finger_exoskeleton { rod1_m: 0.5 rod2_m: 0.5 }"),
       "t.textproto:5: device[0].finger_exoskeleton = { ... }: "},
      {"nothing actuated", linear("actuated: true ", ""),
       "t.textproto:6: device[0].linear.dof = [none actuated]: must have at least one"},
      {"no coordinate", linear("coordinate { name: \"x\" unit: \"m\" }", ""),
       "t.textproto:5: device[0].linear.coordinate: is required: 1 to 72"},
      {"metres and radians without W",
       linear("A: [1, 0.5]", "coordinate { name: \"a\" unit: \"rad\" }\n A: [1, 0.5, 1, 1]"),
       "t.textproto:2: device[0].metric: is required: x holds metres and radians"},
      {"fewer coordinates than DoFs without a prior",
       linear("prior { weight: 0.1 sensed_stiffness: 3 }", ""),
       "t.textproto:2: device[0] = { ... }: prior: must be given, because the condition of J "
       "exceeds "
       "100 in 256 of 256 poses: 1 sensed DoFs, 1 coordinates, which do not determine q: say which "
       "springs hold the rest: prior { weight: 1e-4 sensed_stiffness: [0.05] }"},
      {"W and scales", linear("limits {", "metric { scale_m: 1 W: 1 } limits {"),
       "device[0].metric.W = { with scales }: must be either W or scale_m and scale_rad"},
      {"W that is not positive definite", finger("limits {", "metric { W: [1, 4, 4, 4] } limits {"),
       "device[0].metric.W = [1, 4, 4, 4]: task metric: W must be positive definite; with its "
       "diagonal scaled to 1 its smallest eigenvalue is -1, must be > 1e-12"},
      {"prior of a finger", finger("limits {", "prior { weight: 1 sensed_stiffness: 1 } limits {"),
       "prior: must be absent, because this map has an inverse in closed form"},
  });
}

/// Pastes what the error of `wrong` ends with into `rest`, which lacks it.
void expect_advice(const std::string& wrong, const std::string& rest) {
  const std::string error = error_of(wrong);
  const std::size_t advice = std::max(error.rfind("prior {") + 1, error.rfind("metric {") + 1);
  ASSERT_NE(advice, 0u) << error;
  EXPECT_EQ(error_of(replaced(rest, "limits {", error.substr(advice - 1) + " limits {")),
            "no error");
}

TEST(SceneErrors, AdviceCanBePasted) {
  const std::string prior = "prior { weight: 0.1 sensed_stiffness: 3 }";
  const std::string none = linear(prior, "");
  expect_advice(none, none);
  for (const char* bad : {"prior { sensed_stiffness: 3 }", "prior { weight: 0.1 }",
                          "prior { weight: 1 sensed_stiffness: [1, 2] }",
                          "prior { weight: 1 sensed_stiffness: -1 }"}) {
    expect_advice(linear(prior, bad), none);
  }
  const std::string one_motor = shipped_text("linear_one_motor");
  const std::string shipped = "prior { weight: 1e-4 sensed_stiffness: [0.3, 0.3] }";
  expect_advice(replaced(one_motor, shipped, ""), replaced(one_motor, shipped, ""));
  const std::string mixed =
      linear("A: [1, 0.5]", "coordinate { name: \"a\" unit: \"rad\" }\n A: [1, 0.5, 1, 1]");
  expect_advice(replaced(mixed, prior, ""), replaced(mixed, prior, ""));
  for (const char* bad : {"metric { scale_m: 0 }", "metric { W: [1, 2] }",
                          "metric { W: [1, 4, 4, 4] }", "metric { scale_m: 1 W: [1, 0, 0, 1] }"}) {
    expect_advice(replaced(mixed, prior, bad), replaced(mixed, prior, ""));
  }
}

TEST(SceneErrors, DaemonNamesPlaceAndRule) {
  const auto plus = [](const std::string& message) { return kFinger + message + "\n"; };
  const std::string rule =
      ": must be \"host:port\", \"[v6]:port\" (port 0 to 65535) or "
      "\"unix:/path\"";
  std::vector<BadScene> table = {
      {"twice", plus("server { listen: [\"[::1]:1\", \"[::1]:1\"] }"),
       "t.textproto:11: server.listen[1] = \"[::1]:1\": must be another"},
      {"period beyond the default late fault", kBoard + "loop { period { nanos: 8000000 } }",
       "loop.period = 8 ms: must be below loop_late_fault, which is 8 ms by default"},
      {"record nowhere", plus("record {}"), "t.textproto:11: record.file: is required"},
  };
  for (const char* address : {"localhost", ":1", "host:", "host:65536", "host:1x", "::1:5", "[::1]",
                              "[::1:5", "[]:5", "unix:", "unix:relative", "ho st:1", ""}) {
    table.push_back({address, plus("server { listen: \"" + std::string(address) + "\" }"),
                     "t.textproto:11: server.listen[0] = \"" + std::string(address) + "\"" + rule});
  }
  expect_each_says(table);
  for (const char* address : {"localhost:0", "127.0.0.1:65535", "[::1]:5", "[fe80::1%eth0]:5",
                              "unix:/run/h", "h-1.org:1", "a_host:1"}) {
    EXPECT_EQ(error_of(plus("server { listen: \"" + std::string(address) + "\" }")), "no error");
  }
}

TEST(SceneErrors, InvalidUtf8IsNamed) {
  expect_each_says({
      {"of the scene", replaced(kFinger, "name: \"t\"", "name: \"\\377\""),
       "t.textproto:1: name = \"\\377\": must be UTF-8"},
      {"of a listed text", kFinger + "server { listen: \"\\300\\257:1\" }",
       "t.textproto:11: server.listen[0] = \"\\300\\257:1\": must be UTF-8"},
      {"of an entry", linear("name: \"x\"", "name: \"\\355\\240\\200\""),
       "t.textproto:8: device[0].linear.coordinate[0].name = \"\\355\\240\\200\": must be UTF-8"},
  });
}

TEST(SceneErrors, RecordingsNeverOverwriteTheirSource) {
  const std::string playing =
      replaced(kFinger, "simulated_finger {}",
               "simulated_finger { motion_file: \"motion/reach_and_grasp.csv\" }");
  const std::string same = (kScenes / "motion/reach_and_grasp.csv").string();
  expect_each_says({{"by its own name", playing + "record { file: \"" + same + "\" }",
                     "t.textproto:11: record.file = \"" + same +
                         "\": must be another file: device 'finger' plays"}});
  EXPECT_EQ(error_of(playing + "record { file: \"" + same + ".csv\" }"), "no error");
  // Each of several devices has a file of its own: run-<device>.csv.
  const std::string two = playing + kLinear.substr(kLinear.find("device"));
  EXPECT_EQ(error_of(two + "record { file: \"" + same + "\" }"), "no error");
}

TEST(SceneErrors, AllErrorsComeAtOnce) {
  std::string text =
      replaced(kFinger, "stiffness_n_per_m: 1500", "stifness: 1 stiffness_n_per_m: -3");
  text = replaced(text, "force_n: 20", "force_n: -1 forse: 1") + "loop { priority: 0 }\n";
  for (const char* part : {"7:5: stifness: unknown field", "9:24: forse: unknown field",
                           ":7: device[0].impedance.stiffness_n_per_m[0] = -3: must be > 0",
                           ":9: device[0].limits.force_n[0] = -1: must be > 0",
                           ":11: loop.priority = 0: must be 1 to 98"}) {
    expect_says(text, part);
  }
  const std::string message = error_of(text);
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 4) << message;
}

/// Each problem's place costs a walk through the text: 150,000 of them took a minute.
TEST(SceneErrors, AHundredErrorsAreTold) {
  std::string fields, values;
  for (int i = 0; i < 50'000; ++i) {
    fields += "u:" + std::to_string(i % 10) + "\n";
    values += (i == 0 ? "" : ",") + std::string("nan");
  }
  for (const std::string& text :
       {kFinger + fields, replaced(kFinger, "1500", "[" + values + "]")}) {
    const std::string said = error_of(text);
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 100) << said.substr(0, 200);
    EXPECT_THAT(said, testing::MatchesRegex("(.|\n)*\nt.textproto: and 499[0-9]+ more"));
  }
}

TEST(SceneErrors, AllDevicesErrorsAreTold) {
  const std::string both =
      replaced(kFinger, "finger_exoskeleton {}", "finger_exoskeleton { rod1_m: -1 }") +
      replaced(kLinear.substr(kLinear.find("device")), "lower: -2", "lower: nan");
  expect_says(both, "device[0].finger_exoskeleton.rod1_m");
  expect_says(both, "device[1].linear.dof[1].lower = nan: must be finite");
}

}  // namespace
}  // namespace haptic::test
