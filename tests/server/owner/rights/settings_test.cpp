#include <gtest/gtest.h>

#include <cmath>

#include "tests/server/support/device_rig.hpp"

namespace haptic::test {
namespace {

using core::RendererKind;
using server::Refusal;
using server::SettingsRequest;

/// Session s1 has the lease.
class Settings : public testing::Test {
 protected:
  Settings() { rig.control(); }
  DeviceRig rig;
  SettingsRequest request;
};

TEST_F(Settings, AreTightenedAndClampsAreReported) {
  request.stiffness = {40.0};
  request.force_limit = {50.0};  // the scene's is 10 N
  EXPECT_EQ(rig.sessions->update_settings("s2", request).refusal.code, Refusal::Code::kPermission);
  const auto answer = rig.sessions->update_settings("s1", request);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer.value->stiffness.value[0], 40.0);
  EXPECT_EQ(answer.value->force_limit.value[0], 10.0);
  rig.press();
  EXPECT_NEAR(rig.device->force, 0.4, 1e-9);  // 0.01 m at 40 N/m
}

TEST_F(Settings, WrongFieldsAreNamedAndIgnored) {
  const auto refused = [&](const SettingsRequest& wrong) {
    const auto answer = rig.sessions->update_settings("s1", wrong);
    EXPECT_FALSE(answer);
    EXPECT_EQ(answer.refusal.code, Refusal::Code::kInvalid);
    return answer.refusal.field.str();
  };
  request.stiffness = {1.0, 2.0};
  EXPECT_EQ(refused(request), "stiffness");
  request.stiffness = {std::nan("")};
  EXPECT_EQ(refused(request), "stiffness[0]");
  request.stiffness = {10.0};
  request.damping = {-1.0};
  EXPECT_EQ(refused(request), "damping[0]");
  request.damping = {};
  request.slew_limit = {0.0};
  EXPECT_EQ(refused(request), "slew_limit[0]");
  rig.tick();
  EXPECT_EQ(rig.newest().input.settings.stiffness[0], 100.0);
}

TEST_F(Settings, RendererChangesOnlyWithoutForce) {
  request.renderer = RendererKind::kStandard;
  ASSERT_TRUE(rig.sessions->update_settings("s1", request));
  rig.press();
  ASSERT_EQ(rig.state(), core::LifecycleState::kEngaged);
  EXPECT_EQ(rig.newest().input.settings.renderer, RendererKind::kStandard);
  request.renderer = RendererKind::kSubspaceLinear;
  const auto answer = rig.sessions->update_settings("s1", request);
  EXPECT_EQ(answer.refusal.code, Refusal::Code::kPrecondition);
  EXPECT_NE(answer.refusal.message.view().find("ENGAGED"), std::string::npos);
}

TEST_F(Settings, PendingEngageKeepsTheRenderer) {
  rig.stream(250, 0.01);
  rig.sessions->engage("s1", [](const Outcome<Done>&) {});
  request.renderer = RendererKind::kStandard;
  EXPECT_FALSE(rig.sessions->update_settings("s1", request));
}

TEST_F(Settings, ScenesGuardCannotBeDisabled) {
  request.direction_guard = true;
  EXPECT_TRUE(rig.sessions->update_settings("s1", request).value->direction_guard);
  core::PipelineConfig config = rig_config();
  config.scene.direction_guard = true;
  DeviceRig guarded(config);
  guarded.control();
  request.direction_guard = false;
  EXPECT_FALSE(rig.sessions->update_settings("s1", request).value->direction_guard) << "its own";
  const auto answer = guarded.sessions->update_settings("s1", request);
  EXPECT_EQ(answer.refusal.reason, "GUARD_REQUIRED");
}

TEST_F(Settings, ReturnToScenesAtZeroForce) {
  for (const double stiffness : {90.0, 40.0, 60.0}) {  // they may rise again
    request.stiffness = {stiffness};
    const auto answer = rig.sessions->update_settings("s1", request);
    EXPECT_EQ(answer.value->stiffness.value[0], stiffness);
  }
  rig.press();
  rig.sessions->close("s1");
  for (int i = 0; i < 200; ++i) {
    rig.tick();
    if (rig.newest().life.gain > 0.0) {
      EXPECT_EQ(rig.newest().input.settings.stiffness[0], 60.0);
    }
  }
  EXPECT_EQ(rig.newest().input.settings.stiffness[0], 100.0);
}

}  // namespace
}  // namespace haptic::test
