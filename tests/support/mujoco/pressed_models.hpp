#pragma once
/// Models of the kinds that people have, made of few templates, and how a device is bound to them.

#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "haptic/mujoco/tool.hpp"

namespace haptic::test {

struct PressedModel {
  std::string name{}, mjcf{};
  std::vector<mujoco::Binding> bindings{mujoco::joint("mcp", 0), mujoco::joint("pip", 1)};
  std::vector<double> low{0.2, 0.2}, high{0.8, 1.0};  ///< of x_probe
  double coupling{0.15};
  std::vector<double> weights{};
  /// The client says that not all is told that holds it; empty: at times.
  std::optional<bool> warned{false};
  bool keep_actuators{false};
};

/// Coordinates of a binding.
inline std::size_t width(const mujoco::Binding& one) {
  using Kind = mujoco::Binding::Kind;
  return one.kind == Kind::kJoint ? 1 : one.kind == Kind::kPoint ? 3 : 7;
}

/// Probes, at random but always the same.
inline std::vector<std::vector<double>> presses(const PressedModel& model, int count) {
  std::minstd_rand random(1);
  std::vector<std::vector<double>> all(static_cast<std::size_t>(count), model.low);
  for (std::vector<double>& x : all) {
    for (std::size_t c = 0; c < x.size(); ++c) {
      x[c] += (model.high[c] - x[c]) * static_cast<double>(random() % 1000) / 1000.0;
    }
    if (x.size() < 7) continue;
    const double length = std::sqrt(x[3] * x[3] + x[4] * x[4] + x[5] * x[5] + x[6] * x[6]);
    for (std::size_t c = 3; c < 7; ++c) x[c] /= length;
  }
  return all;
}

/// Attributes and elements that differ between models.
struct Parts {
  std::string dip = R"(<joint name="dip"/>)";  ///< none: the end is fixed
  std::string end = R"(<geom fromto="0 0 0 0.018 0 0" size="0.006"/>)";
  std::string more{};    ///< in the world
  std::string beyond{};  ///< beyond the world: equalities, tendons, actuators
  std::string option = R"(gravity="0 0 0")";
  std::string joint{};  ///< of all
  std::string geom = R"(condim="1")";
  std::string assets{};
};

/// A finger over a soft wall: phalanges of 45, 25 and 18 mm.
inline std::string finger_of(const Parts& p) {
  return R"(<mujoco><compiler angle="radian"/><option timestep="0.001" )" + p.option + R"(/>
  <asset>)" +
         p.assets + R"(</asset>
  <default><geom type="capsule" density="1000" )" +
         p.geom + R"(/>
    <joint axis="0 0 -1" armature="1e-5" )" +
         p.joint + R"(/></default>
  <worldbody>
    <body name="p1"><joint name="mcp"/><geom fromto="0 0 0 0.045 0 0" size="0.008"/><site name="s1"
      pos="0.02 0.008 0"/>
      <body name="p2" pos="0.045 0 0"><joint name="pip"/>
        <geom fromto="0 0 0 0.025 0 0" size="0.007"/><site name="s2" pos="0.012 0.008 0"/>
        <body name="p3" pos="0.025 0 0">)" +
         p.dip + p.end + R"(<site name="s3" pos="0.009 0.007 0"/>
        </body></body></body>
    <geom name="wall" type="plane" pos="0 -0.035 0" zaxis="0 1 0" size="1 1 0.1"
          solref="-2000 -20" solimp="0.5 0.5 0.001"/>)" +
         p.more + R"(
  </worldbody><contact><exclude body1="p1" body2="p3"/></contact>)" +
         p.beyond + "</mujoco>";
}

inline std::string mimic(const std::string& polycoef, const std::string& more = "",
                         const std::string& of = "dip", const std::string& leader = "pip") {
  return "<equality><joint joint1='" + of + "' joint2='" + leader + "' polycoef='" + polycoef +
         "' " + (more.empty() ? "solref='0.004 1' solimp='0.99 0.999 0.001'" : more) +
         "/></equality>";
}

inline const std::string kTendon = R"(<joint joint="dip" coef="0.01"/>
    <joint joint="pip" coef="-0.0067"/></fixed></tendon>)";

/// A four-bar linkage: a driver turns, and a pad hangs on its rocker, which is not below it.
inline std::string linkage(const std::string& n, const std::string& z) {
  return R"(<body name="driver)" + n + R"(" pos="0 0 )" + z + R"("><joint name="driver)" + n +
         R"("/><geom fromto="0 0 0 0 -0.03 0" size="0.003"/>
      <body name="bar)" +
         n + R"(" pos="0 -0.03 0"><joint name="bar)" + n + R"("/>
        <geom fromto="0 0 0 0.04 0 0" size="0.003"/></body></body>
    <body name="rocker)" +
         n + R"(" pos="0.04 0 )" + z + R"("><joint name="rocker)" + n +
         R"("/><geom fromto="0 0 0 0 -0.03 0" size="0.003"/>
      <body name="pad)" +
         n + R"(" pos="0 -0.04 0"><geom type="box" size="0.006 0.006 0.006"
        contype="1" conaffinity="1"/></body></body>)";
}
inline std::string closed(const std::string& n) {
  return R"(<connect body1="bar)" + n + R"(" body2="rocker)" + n + R"(" anchor="0.04 0 0"
    solref="0.004 1" solimp="0.99 0.999 0.001"/>)";
}
inline std::string gripper(const std::string& bodies, const std::string& rows,
                           const std::string& joint = "damping=\"1e-4\"") {
  return R"(<mujoco><compiler angle="radian"/><option timestep="0.001"/>
  <default><geom type="capsule" density="1000" condim="1" contype="0" conaffinity="0"/>
    <joint axis="0 0 1" armature="1e-5" )" +
         joint + R"(/></default>
  <worldbody>)" +
         bodies + R"(<geom type="plane" pos="0.055 0 0" zaxis="-1 0 0" size="1 1 0.1"
    contype="1" conaffinity="1" solref="-2000 -20" solimp="0.5 0.5 0.001"/></worldbody>
  <equality>)" +
         rows + "</equality></mujoco>";
}

/// Fingers whose end joint differs.
inline void add_fingers(std::vector<PressedModel>& all) {
  const auto add = [&all](const std::string& name, const Parts& parts) -> PressedModel& {
    all.push_back({.name = name, .mjcf = finger_of(parts)});
    return all.back();
  };
  const std::string heavy = R"(gravity="0 -9.81 0")";
  const std::string line = "0 0.67 0 0 0";
  add("fixed end", {.dip = ""});
  add("mimic", {.beyond = mimic(line)});
  add("mimic, as soft as MuJoCo's default", {.beyond = mimic(line, "solref='0.02 1'")});
  add("mimic, curved", {.beyond = mimic("0.05 0.4 0.2 0 0")});
  add("mimic, backwards", {.beyond = mimic("0.1 -0.5 0 0 0")});
  add("mimic with weight, spring, friction and limits",
      {.dip = R"(<joint name="dip" stiffness="0.02" damping="1e-3" range="0 0.3" limited="true"/>)",
       .beyond = mimic(line),
       .option = heavy,
       .joint = R"(frictionloss="0.003")"});
  add("mimic with servos", {.beyond = mimic(line) + R"(<actuator><position joint="mcp" kp="1"/>
        <position name="end" joint="dip" kp="1"/><velocity joint="pip" kv="0.1"/></actuator>)",
                            .option = heavy});
  add("free end", {.dip = R"(<joint name="dip" range="-0.1 1" limited="true" damping="1e-4"/>)"});
  add("end on a spring", {.dip = R"(<joint name="dip" stiffness="0.05" damping="1e-4"/>)"});
  add("end held by its own servo", {.beyond = R"(<actuator><position joint="dip" kp="0.5"/>
    </actuator>)",
                                    .joint = R"(damping="1e-3")"});
  add("two joints of one coordinate", {.option = heavy})
      .bindings.push_back(mujoco::joint("dip", 1, 0.67));
  add("one motor", {.beyond = mimic(line) + mimic("0 0.9 0 0 0", "", "pip", "mcp")});
  all.back().bindings = {mujoco::joint("mcp", 0)};
  all.back().low = {0.3};
  all.back().high = {0.8};
  add("one coordinate for all", {.joint = R"(damping="1e-3")"});
  all.back().bindings = {mujoco::joint("mcp", 0), mujoco::joint("pip", 0, 0.9, 0.05),
                         mujoco::joint("dip", 0, 0.6)};
  all.back().low = {0.3};
  all.back().high = {0.8};
  add("other signs and zeros", {.beyond = mimic(line)}).bindings = {
      mujoco::joint("mcp", 0, -1.0, 0.2), mujoco::joint("pip", 1, 0.5)};
  all.back().low = {-0.5, 0.6};
  all.back().high = {0.0, 2.0};
  add("limited tendon",
      {.beyond = R"(<tendon><fixed limited="true" range="-0.0005 0.0005">)" + kTendon});
  add("limited tendon with weight", {.beyond = R"(<tendon><fixed limited="true"
      range="-0.001 0.001" frictionloss="0.02">)" +
                                               kTendon,
                                     .option = heavy});
  add("tendon equality", {.beyond = R"(<tendon><fixed name="t">)" + kTendon +
                                    R"(<equality><tendon tendon1="t" solref="0.004 1"
              solimp="0.99 0.999 0.001"/></equality>)"});
  add("spring tendon", {.beyond = R"(<tendon><fixed stiffness="400" damping="0.5">)" + kTendon});
  add("tendon with a servo", {.beyond = R"(<tendon><fixed name="t"><joint joint="dip" coef="1"/>
      <joint joint="pip" coef="1"/></fixed></tendon>
      <actuator><position tendon="t" kp="1"/></actuator>)",
                              .joint = R"(damping="1e-3")"});
  add("one motor, springs share",
      {.dip = R"(<joint name="dip" stiffness="0.03"/>)",
       .beyond = R"(<tendon><fixed name="t"><joint joint="mcp" coef="-0.01"/>
        <joint joint="pip" coef="0.008"/><joint joint="dip" coef="0.006"/></fixed></tendon>
        <equality><tendon tendon1="t" solref="0.004 1" solimp="0.99 0.999 0.001"/></equality>)",
       .joint = R"(stiffness="0.05" damping="1e-3")"});
  all.back().bindings = {mujoco::joint("mcp", 0)};
  all.back().low = {0.3};
  all.back().high = {0.8};
  add("rough", {.beyond = mimic(line), .geom = R"(condim="3" friction="1 0.005 0.0001")"})
      .warned.reset();
  add("servos that stay", {.dip = "", .beyond = R"(<actuator><position joint="pip" kp="0.3"/>
      </actuator>)"})
      .warned = true;
  all.back().keep_actuators = true;
  add("tied to the world", {.dip = "", .beyond = R"(<equality><connect body1="p3"
      anchor="0 0 0"/></equality>)"})
      .warned = true;
}

/// Shapes, objects and solvers.
inline void add_worlds(std::vector<PressedModel>& all) {
  const auto add = [&all](const std::string& name, Parts parts) -> PressedModel& {
    parts.beyond += mimic("0 0.67 0 0 0");
    all.push_back({.name = name, .mjcf = finger_of(parts)});
    return all.back();
  };
  const std::string tetrahedron =
      R"(<mesh name="tip" vertex="-0.002 -0.006 -0.006  -0.002 -0.006 0.006
    0 0.006 0  0.02 -0.004 0.004  0.02 -0.004 -0.004"/>)";
  add("mesh", {.end = R"(<geom type="mesh" mesh="tip"/>)", .assets = tetrahedron});
  add("several geoms", {.end = R"(<geom fromto="0 0 0 0.012 0 0" size="0.006"/>
      <geom type="box" pos="0.012 -0.001 0" size="0.006 0.005 0.006"/>
      <geom type="sphere" pos="0.02 0 0" size="0.005"/>)"});
  add("ellipsoid", {.end = R"(<geom type="ellipsoid" pos="0.009 0 0" size="0.012 0.006 0.006"/>)"});
  add("nested", {.end =
                     R"(<geom size="0.005" fromto="0 0 0 0.004 0 0"/>
      <body pos="0.004 0 0"><body euler="0 0 -0.2"><geom fromto="0 0 0 0.014 0 0" size="0.006"/>
      <body pos="0.014 0 0"><geom type="sphere" size="0.007"/></body></body></body>)"});
  add("soft pad",
      {.end = R"(<geom fromto="0 0 0 0.018 0 0" size="0.004"/><body pos="0.012 -0.004 0">
      <joint type="slide" axis="0 1 0" stiffness="300" damping="1" armature="0.002"/>
      <geom type="sphere" size="0.005"/></body>)"});
  const std::string ball = R"(<body pos="0.05 -0.025 0">
      <joint type="slide" axis="1 0 0" stiffness="300" damping="1"/>
      <joint type="slide" axis="0 1 0" stiffness="300" damping="1"/>
      <joint type="slide" axis="0 0 1" stiffness="300" damping="1"/>
      <geom type="sphere" size="0.012" mass="0.03"/></body>)";
  add("ball on springs", {.more = ball});
  add("free box against a wall", {.more = R"(<body pos="0.05 -0.0265 0"><freejoint/>
      <geom type="box" size="0.012 0.008 0.02" mass="0.05"/></body>)",
                                  .option = R"(gravity="0 -9.81 0")"});
  add("welded box", {.more = R"(<body name="box" pos="0.098 -0.012 0"><freejoint/>
      <geom type="box" size="0.008 0.005 0.008" mass="0.01"/></body>)",
                     .beyond = R"(<equality><weld body1="p3" body2="box" solref="0.004 1"
        solimp="0.99 0.999 0.001"/></equality>)",
                     .option = R"(gravity="0 -9.81 0")"});
  add("sparse, elliptic, CG",
      {.more = ball, .option = R"(gravity="0 0 0" jacobian="sparse" cone="elliptic" solver="CG")"});
  add("PGS", {.option = R"(gravity="0 0 0" solver="PGS" iterations="400" tolerance="1e-12")"});
}

/// Models that are not this finger.
inline void add_others(std::vector<PressedModel>& all) {
  const auto add = [&all](const std::string& name, const std::string& mjcf) -> PressedModel& {
    all.push_back({.name = name,
                   .mjcf = mjcf,
                   .bindings = {mujoco::joint("driver1", 0)},
                   .low = {0.2},
                   .high = {0.6}});
    return all.back();
  };
  add("closed chain", gripper(linkage("1", "0"), closed("1")));
  add("closed chain with a spring", gripper(linkage("1", "0"), closed("1"),
                                            R"(damping="1e-4" stiffness="0.01" springref="-0.2")"));
  add("gripper of two",
      gripper(linkage("1", "0") + linkage("2", "0.1"),
              closed("1") + closed("2") +
                  R"(<joint joint1="driver2" joint2="driver1" solref="0.004 1"/>)"));
  add("rack and pinion", R"(<mujoco><option timestep="0.001"/><compiler angle="radian"/>
    <default><geom condim="1"/><joint armature="1e-5"/></default><worldbody>
    <body name="rack"><joint name="rack" type="slide" axis="1 0 0"/>
      <geom type="box" size="0.01 0.002 0.002" mass="0.02" contype="0" conaffinity="0"/></body>
    <body name="wheel" pos="0 0.03 0"><joint name="wheel" axis="0 0 1"/>
      <geom type="capsule" fromto="0 0 0 0.04 0 0" size="0.004" mass="0.01"/></body>
    <geom type="plane" pos="0 0.04 0" zaxis="0 -1 0" size="1 1 1"/></worldbody>
    <equality><joint joint1="wheel" joint2="rack" polycoef="0 50 0 0 0"/></equality></mujoco>)");
  all.back().bindings = {mujoco::joint("rack", 0)};
  all.back().low = {0.004};
  all.back().high = {0.012};
  all.back().coupling = 500.0;
  add("stylus",
      R"(<mujoco><option timestep="0.001"/><default><geom condim="1"/></default><worldbody>
    <body name="pen" pos="0 0 0.1"><freejoint/><geom type="capsule" fromto="0 0 0 0.06 0 0.01"
      size="0.01" mass="0.05"/></body>
    <geom type="plane" size="1 1 1" solref="-3000 -60" solimp="0.5 0.5 0.001"/>
    </worldbody></mujoco>)");
  all.back().bindings = {mujoco::pose("pen", 0)};
  all.back().low = {-0.02, -0.02, 0.0, -0.2, -0.2, -0.2, 0.9};
  all.back().high = {0.02, 0.02, 0.005, 0.2, 0.2, 0.2, 1.0};
  all.back().weights = {1, 1, 1, 0.004, 0.004, 0.004, 0.004};
  all.back().coupling = 400.0;
  add("point", R"(<mujoco><option timestep="0.001"/><default><geom condim="1"/></default><worldbody>
    <body name="pad" pos="0 0 0.05"><joint type="slide" axis="1 0 0"/><joint type="slide"
      axis="0 1 0"/><joint type="slide" axis="0 0 1"/><geom type="sphere" size="0.01" mass="0.02"/>
    </body><geom type="sphere" size="0.03"/></worldbody></mujoco>)");
  all.back().bindings = {mujoco::point("pad", 0)};
  all.back().low = {-0.01, -0.01, 0.028};
  all.back().high = {0.01, 0.01, 0.038};
  all.back().coupling = 500.0;
}

/// Inputs of people, if they are here, next to the project.
inline const char* const kCases = HAPTIC_SOURCE_DIR "/../shared/cases/mujoco";
inline bool has_cases() {
  return std::filesystem::is_directory(kCases);
}
inline void add_cases(std::vector<PressedModel>& all) {
  if (!has_cases()) return;
  for (const auto& entry : std::filesystem::directory_iterator(kCases)) {
    std::ostringstream text;
    text << std::ifstream(entry.path()).rdbuf();
    all.push_back({.name = entry.path().filename().string(),
                   .mjcf = text.str(),
                   .bindings = {mujoco::joint("q_o1_mcp", 0), mujoco::joint("q_o2_pip", 1)}});
  }
}

inline std::vector<PressedModel> pressed_models() {
  std::vector<PressedModel> all;
  add_fingers(all);
  add_worlds(all);
  add_others(all);
  add_cases(all);
  return all;
}

}  // namespace haptic::test
