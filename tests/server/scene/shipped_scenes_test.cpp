#include <algorithm>
#include <typeinfo>

#include "hw/board/board_device.hpp"
#include "tests/server/scene/scene_text.hpp"

namespace haptic::test {
namespace {

std::vector<std::filesystem::path> shipped() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(kScenes)) {
    if (entry.path().extension() == ".textproto") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

void expect_same(const core::RenderSettings& a, const core::RenderSettings& b) {
  EXPECT_EQ(a.renderer, b.renderer);
  EXPECT_EQ(a.direction_guard, b.direction_guard);
  EXPECT_EQ(a.stiffness, b.stiffness);
  EXPECT_EQ(a.damping, b.damping);
  EXPECT_EQ(a.force_limit, b.force_limit);
  EXPECT_EQ(a.slew_limit, b.slew_limit);
  EXPECT_EQ(a.engage_window, b.engage_window);
  EXPECT_EQ(a.staleness, b.staleness);
}

void expect_same(const std::shared_ptr<const core::StiffnessCoupling>& a,
                 const std::shared_ptr<const core::StiffnessCoupling>& b) {
  ASSERT_EQ(a == nullptr, b == nullptr);
  if (a) {
    EXPECT_EQ(a->matrix(a->scene_stiffness()), b->matrix(b->scene_stiffness()));
  }
}

TEST(ShippedScenes, OpenTheirDevices) {
  const auto files = shipped();
  EXPECT_GE(files.size(), 8u);
  for (const auto& file : files) {
    SCOPED_TRACE(file.filename());
    const server::Scene scene = server::load_scene(file);
    for (const server::DeviceScene& device : scene.devices) {
      if (device.source->is_hardware()) continue;
      const auto opened = hw::open_device(*device.source, device.pipeline.kinematics);
      ASSERT_NE(opened, nullptr);
      EXPECT_EQ(opened->info().limits.max_effort.size(), device.pipeline.scene.force_limit.size());
    }
  }
}

TEST(ShippedScenes, ReadBackFromTheirResolvedTextAsTheSameScene) {
  for (const auto& file : shipped()) {
    SCOPED_TRACE(file.filename());
    const server::Scene scene = server::load_scene(file);
    const server::Scene again = server::parse_scene(scene.resolved, "resolved", "/");
    EXPECT_EQ(again.resolved, scene.resolved);
    EXPECT_EQ(again.name, scene.name);
    EXPECT_EQ(again.server.listen, scene.server.listen);
    EXPECT_EQ(again.loop.period, scene.loop.period);
    EXPECT_EQ(again.loop.loop_late_fault, scene.loop.loop_late_fault);
    EXPECT_EQ(again.record.has_value(), scene.record.has_value());
    ASSERT_EQ(again.devices.size(), scene.devices.size());
    for (std::size_t i = 0; i < scene.devices.size(); ++i) {
      EXPECT_EQ(again.devices[i].name, scene.devices[i].name);
      EXPECT_EQ(again.devices[i].fresh_end, scene.devices[i].fresh_end);
      const hw::DeviceConfig &a = *again.devices[i].source, &b = *scene.devices[i].source;
      EXPECT_EQ(typeid(a), typeid(b));
      expect_same(again.devices[i].pipeline.scene, scene.devices[i].pipeline.scene);
      expect_same(again.devices[i].pipeline.projection.coupling,
                  scene.devices[i].pipeline.projection.coupling);
    }
  }
}

TEST(ShippedScenes, RenderNothingThatTheirDevicesCannotPayFor) {
  for (const auto& file : shipped()) {
    for (const std::string& warning : server::load_scene(file).warnings) {
      ADD_FAILURE() << file.filename() << ": " << warning;
    }
  }
}

}  // namespace
}  // namespace haptic::test
