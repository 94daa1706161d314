// Direction guard and energy tank: there by default, left out by a word.
#include <gmock/gmock.h>

#include <Eigen/Cholesky>

#include "server/owner/state/device_message.hpp"
#include "tests/server/owner/scene/scene_run.hpp"
#include "tests/server/owner/scene/scene_text.hpp"

namespace haptic::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

core::PipelineConfig pipeline_of(const std::string& option, const std::string& text = kFinger) {
  return parse(with_option(text, option)).devices[0].pipeline;
}

std::vector<std::string> unguarded(const core::PipelineConfig& config) {
  const v1::Device message = server::describe("d", {}, config);
  return {message.unguarded().begin(), message.unguarded().end()};
}

TEST(Safeguards, AreThereByDefault) {
  const server::Scene scene = parse(kFinger);
  const core::PipelineConfig& device = scene.devices[0].pipeline;
  EXPECT_TRUE(device.scene.direction_guard);
  EXPECT_TRUE(device.passivity.tank.enabled);
  EXPECT_TRUE(device.derating);
  EXPECT_THAT(scene.warnings, testing::IsEmpty());
  EXPECT_THAT(unguarded(device), testing::IsEmpty());
  expect_resolved(scene, "direction_guard");
  expect_resolved(scene, "initial_j: 0.00833");

  EXPECT_TRUE(pipeline_of("passivity { observer {} }").passivity.tank.enabled);
}

TEST(Safeguards, OneWordLeavesThemOut) {
  const server::Scene scene = parse(with_option(kFinger, "unguarded {}"));
  const core::PipelineConfig& device = scene.devices[0].pipeline;
  EXPECT_FALSE(device.scene.direction_guard);
  EXPECT_FALSE(device.passivity.enabled());
  EXPECT_FALSE(device.derating);
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("device[0].unguarded: no direction_guard"),
                                          HasSubstr("device[0].unguarded: no passivity.tank")));
  EXPECT_THAT(unguarded(device), ElementsAre("direction_guard", "energy_tank"));
  expect_resolved(scene, "unguarded");
}

TEST(Safeguards, ANamedOneStays) {
  const server::Scene guard = parse(with_option(kFinger, "unguarded {} direction_guard {}"));
  EXPECT_TRUE(guard.devices[0].pipeline.scene.direction_guard);
  EXPECT_THAT(guard.warnings, ElementsAre(HasSubstr("no passivity.tank")));
  const server::Scene tank = parse(with_option(kFinger, "unguarded {} passivity { tank {} }"));
  EXPECT_THAT(tank.warnings, ElementsAre(HasSubstr("no direction_guard")));
}

TEST(Safeguards, ErrorsNameConflictingWords) {
  const std::string tank = "unguarded {} passivity { tank {} } ";
  expect_each_says({
      {"guard", with_option(kFinger, tank + "direction_guard {}"),
       "device[0].unguarded = { with direction_guard and passivity.tank }: must be absent"},
      {"nothing", with_option(kFinger, "unguarded {} passivity {}"), "device[0].passivity.tank"},
  });
}

TEST(Safeguards, TheTankPaysTheWindow) {
  // 1/2 w^2 / K: w = 20 N / 4 and 1500 N/m, 2 N / 4 and 5 N/m.
  EXPECT_DOUBLE_EQ(pipeline_of("").passivity.tank.initial, 0.5 * 25.0 / 1500.0);
  EXPECT_EQ(pipeline_of("").passivity.tank.capacity, 0.05);
  EXPECT_DOUBLE_EQ(pipeline_of("", kLinear).passivity.tank.initial, 0.5 * 0.25 / 5.0);
  const auto wide = parse(replaced(kFinger, "force_n: 20", "force_n: 20 engage_window_n: 20"));
  EXPECT_DOUBLE_EQ(wide.devices[0].pipeline.passivity.tank.initial, 0.5 * 400.0 / 1500.0);
  EXPECT_EQ(wide.devices[0].pipeline.passivity.tank.capacity,
            wide.devices[0].pipeline.passivity.tank.initial);
  EXPECT_EQ(pipeline_of("passivity { tank {} }").passivity.tank.initial, 0.0) << "strict";
  // No spring stores more than at the force limit, whatever the window; a soft one is warned of.
  const auto open = parse(replaced(kFinger, "force_n: 20", "force_n: 20 engage_window_n: 1000"));
  EXPECT_EQ(open.devices[0].pipeline.passivity.tank.initial,
            wide.devices[0].pipeline.passivity.tank.initial);
  const auto soft = parse(replaced(kFinger, "stiffness_n_per_m: 1500", "stiffness_n_per_m: 1"));
  EXPECT_THAT(soft.warnings, testing::Contains(HasSubstr("device[0].passivity.tank.initial_j")));
}

/// A coupled Z_q: every force within the window stores at most that.
TEST(Safeguards, TheTankPaysACoupledWindow) {
  const server::DeviceScene stylus =
      parse(replaced(shipped_text("stylus_cartesian"), "tank { initial_j: 0.01 }", "")).devices[0];
  const core::RenderSettings& s = stylus.pipeline.scene;
  ASSERT_NE(stylus.pipeline.projection.coupling, nullptr);
  const Eigen::MatrixXd Z = stylus.pipeline.projection.coupling->matrix(s.stiffness);
  double most = 0.0;
  for (int signs = 0; signs < 8; ++signs) {
    Eigen::VectorXd tau = s.engage_window;
    for (int i = 0; i < 3; ++i) tau[i] *= (signs >> i) & 1 ? 1.0 : -1.0;
    most = std::max(most, 0.5 * tau.dot(Z.llt().solve(tau)));
  }
  EXPECT_GE(stylus.pipeline.passivity.tank.initial, most * (1.0 - 1e-12));
  EXPECT_LE(stylus.pipeline.passivity.tank.initial, 1.5 * most);
}

}  // namespace
}  // namespace haptic::test
