// A simulation of somebody else: the library is found, compiles and links.
#include <haptic/mujoco/tool.hpp>

#include <cstdio>
#include <stdexcept>

int main() {
  mjModel* model = mj_loadXML("none.xml", nullptr, nullptr, 0);
  if (model == nullptr) return 0;
  try {
    haptic::mujoco::Tool tool(model, mj_makeData(model), {haptic::mujoco::joint("x", 0)}, {});
  } catch (const std::invalid_argument& error) {
    std::puts(error.what());
  }
}
