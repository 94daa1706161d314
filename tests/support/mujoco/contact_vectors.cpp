/// Contacts that haptic::mujoco tells of a shipped model while a probe presses: lines of JSON, for
/// the test of the same in TypeScript (tests/client/js/mujoco_test.mjs). Each line is a step of 1
/// ms; every 20th says the state before it, and what was told after it.
///
///   haptic_mujoco_vectors MODEL.xml    of client/mujoco/examples
///   haptic_mujoco_vectors --pressed N  the models of pressed_models.hpp and N probes of each

#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "tests/mujoco/mujoco_world.hpp"
#include "tests/support/mujoco/pressed_models.hpp"

namespace {

using namespace haptic;
using nlohmann::json;
constexpr int kSteps = 600, kTold = 20;

/// A pose and points of a hand, or the joints of a finger; and a motion that presses.
struct Motion {
  explicit Motion(const mujoco::World& world) : world_(&world) {
    mj_forward(world.m(), world.d());
    if (world.id(mjOBJ_SITE, "wrist") < 0) {
      bindings = {mujoco::joint("q_o1_mcp", 0), mujoco::joint("q_o2_pip", 1)};
      return;
    }
    bindings = {mujoco::pose("wrist", 0)};
    for (const char* site : {"index_tip", "index_pad", "middle_tip", "middle_pad", "palm_radial"}) {
      bindings.push_back(mujoco::point(site, 3 * bindings.size() + 4));
    }
    start_ = {0, 0, 0, 0, 0, 0, 0};
    for (const mujoco::Binding& binding : bindings) {
      const mjtNum* at = world.d()->site_xpos + 3 * world.id(mjOBJ_SITE, binding.name.c_str());
      if (binding.kind == mujoco::Binding::Kind::kPoint) start_.insert(start_.end(), at, at + 3);
      if (binding.kind == mujoco::Binding::Kind::kPose) std::copy(at, at + 3, start_.begin());
    }
    mjtNum turn[4];
    mju_mat2Quat(turn, world.d()->site_xmat + 9 * world.id(mjOBJ_SITE, "wrist"));
    for (std::size_t i = 0; i < 4; ++i) start_[3 + i] = turn[(i + 1) % 4];
  }
  [[nodiscard]] std::vector<double> at(double part) const {
    if (start_.empty()) return {0.95 * part, 0.9 * part * part};
    std::vector<double> x = start_;
    const auto move = [&](std::size_t i) {
      x[i + 1] += 0.155 * std::sqrt(part);
      x[i + 2] -= 0.118 * part * part;
    };
    move(0);
    for (std::size_t i = 7; i < x.size(); i += 3) move(i);
    x[3] += 0.02 * part;
    return x;
  }

  std::vector<mujoco::Binding> bindings{};

 private:
  const mujoco::World* world_;
  std::vector<double> start_{};
};

json told(const client::Proxy& proxy) {
  json planes = json::array();
  for (const client::Plane& plane : proxy.planes) {
    planes.push_back({{"normal", plane.normal},
                      {"offset", plane.offset},
                      {"compliance", plane.compliance},
                      {"velocity", plane.velocity},
                      {"curvature", plane.curvature},
                      {"firstCoordinate", plane.first_coordinate},
                      {"id", plane.id},
                      {"mass", plane.mass},
                      {"damping", plane.damping},
                      {"groundStiffness", plane.ground_stiffness},
                      {"load", plane.load},
                      {"object", plane.object},
                      {"objectDirection", plane.object_direction}});
  }
  return {{"position", proxy.position}, {"planes", planes}};
}

void print_pressed(int presses) {
  for (const test::PressedModel& model : test::pressed_models()) {
    json bindings = json::array();
    for (const mujoco::Binding& one : model.bindings) {
      bindings.push_back({{"kind", static_cast<int>(one.kind)},
                          {"name", one.name},
                          {"firstCoordinate", one.first_coordinate},
                          {"scale", one.scale},
                          {"offset", one.offset}});
    }
    json line{{"name", model.name},
              {"mjcf", model.mjcf},
              {"bindings", bindings},
              {"coupling", model.coupling},
              {"warned", nullptr},
              {"keepActuators", model.keep_actuators},
              {"probes", test::presses(model, presses)}};
    if (model.warned) line["warned"] = *model.warned;
    if (!model.weights.empty()) line["weights"] = model.weights;
    std::cout << line << "\n";
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3 && argv[1] == std::string("--pressed")) {
    print_pressed(std::stoi(argv[2]));
    return 0;
  }
  if (argc != 2) return 2;
  const mujoco::World world = mujoco::World::of_file(argv[1]);
  mjModel& model = *world.m();
  mjData& data = *world.d();
  model.opt.tolerance = 0.0;  // two releases stop where numbers end
  model.opt.iterations = 50;
  const Motion motion(world);
  const double coupling = model.numeric_data[0];
  mujoco::Tool tool(&model, &data, motion.bindings, {.coupling = coupling});
  json bindings = json::array();
  for (const mujoco::Binding& binding : motion.bindings) {
    bindings.push_back({binding.name, static_cast<int>(binding.kind), binding.first_coordinate});
  }
  std::cout << json{{"bindings", bindings}, {"coupling", coupling}} << "\n";
  for (int i = 1; i <= kSteps; ++i) {
    const double part = 0.5 - 0.5 * std::cos(3.14159 * std::min(1.0, 1.2 * i / kSteps));
    json line{{"probe", motion.at(part)}};
    if (i % kTold == 0) {
      line["qpos"] = std::vector<double>(data.qpos, data.qpos + model.nq);
      line["qvel"] = std::vector<double>(data.qvel, data.qvel + model.nv);
      line["warm"] = std::vector<double>(data.qacc_warmstart, data.qacc_warmstart + model.nv);
    }
    tool.aim(motion.at(part), 1, std::chrono::milliseconds(20));
    tool.pull();
    if (i % kTold == 0) {
      line["applied"] = std::vector<double>(data.qfrc_applied, data.qfrc_applied + model.nv);
    }
    mj_step(&model, &data);
    const client::Proxy proxy = tool.proxy();
    if (i % kTold == 0) line["told"] = told(proxy);
    std::cout << line << "\n";
  }
}
