// A device that the product does not know: its configuration alone connects it, and no file outside
// the recipe of CONTRIBUTING.md#adding-a-device names a device.
#include <regex>
#include <set>

#include "haptic/v1/scene.pb.h"
#include "tests/server/owner/scene/scene_run.hpp"
#include "tests/server/owner/scene/scene_text.hpp"

namespace haptic::hw::readme {
std::unique_ptr<const DeviceConfig> spring();  // tests/checks/hw_readme.cpp
}

namespace haptic::test {
namespace {

namespace fs = std::filesystem;

TEST(NewDevice, ItsConfigurationAloneConnectsIt) {
  const auto spring = hw::readme::spring();
  const server::Scene scene = parse(R"(name: "t"
device {
  name: "d"
  simulated_linear { mass: 1 max_effort: 5 }
  linear {
    dof { name: "s" unit: "m" actuated: true lower: -1 upper: 1 }
    coordinate { name: "x" unit: "m" }
    A: 1
  }
  impedance { stiffness_n_per_m: 20 }
  limits { force_n: 5 }
})");
  SceneRun run(scene.devices[0], *spring);
  run.engage();
  run.hold_at(core::VecX::Constant(1, 0.1));
  run.run(2000);
  // tau = K (x - q) at rest with q = tau / k of the spring: K = 20 N/m, k = 100 N/m, x = 0.1 m.
  EXPECT_NEAR(run.record().effort.tau_a[0], 20.0 * 0.1 / (1.0 + 20.0 / 100.0), 1e-6);
  const auto two_dofs = parse(kLinear).devices[0].pipeline.kinematics;
  EXPECT_THROW(static_cast<void>(spring->open(two_dofs, {})), core::DeviceError);
}

TEST(NewDevice, OnlyRecipeFilesNameADevice) {
  const fs::path root = HAPTIC_SOURCE_DIR;
  // The sources of the scene's schema, as code would name them: SimulatedFinger, simulated_finger.
  std::string types;
  std::string fields;
  std::string folders;
  const auto* sources = v1::DeviceScene::descriptor()->FindOneofByName("source");
  for (int i = 0; i < sources->field_count(); ++i) {
    const auto* source = sources->field(i);
    types += "|" + source->message_type()->name();
    fields += "|" + source->name();
    folders += "|" + source->name().substr(0, source->name().find('_'));
  }
  const auto any = [](const std::string& names) { return "(" + names.substr(1) + ")"; };
  const std::regex names("\\b" + any(types) + "Config\\b|BoardDevice|hw/" + any(folders) +
                         "/[a-z_]*(device|replay|finger|linear)\\.hpp|DeviceScene::k" + any(types) +
                         "|(has|mutable)_" + any(fields) + "\\(");
  std::set<std::string> naming;
  for (const char* room : {"core", "hw", "server", "client", "proto"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / room)) {
      const std::string name = entry.path().lexically_relative(root).generic_string();
      const std::string extension = entry.path().extension().string();
      if (extension != ".cpp" && extension != ".hpp") continue;
      if (std::regex_search(file_text(entry.path()), names)) naming.insert(name);
    }
  }
  const std::regex recipe("hw/(emulator|" + any(folders).substr(1) +
                          "/.*|server/owner/scene/source\\.cpp");
  for (const std::string& name : naming) EXPECT_TRUE(std::regex_match(name, recipe)) << name;
  EXPECT_EQ(naming.count("server/owner/scene/source.cpp"), 1u);
}

}  // namespace
}  // namespace haptic::test
