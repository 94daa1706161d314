#include <gtest/gtest.h>

#include <cmath>

#include "server/front/messages.hpp"
#include "tests/server/support/device_rig.hpp"

namespace haptic::test {
namespace {

using core::RendererKind;
using server::Refusal;
using server::SettingsRequest;

TEST(Settings, AreTightenedAndClampsAreReported) {
  DeviceRig rig;
  rig.control();
  SettingsRequest request;
  request.stiffness = {40.0};
  request.force_limit = {50.0};  // the scene's is 10 N
  const auto answer = rig.sessions->update_settings("s1", request);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer.value->stiffness.value[0], 40.0);
  EXPECT_EQ(answer.value->force_limit.value[0], 10.0);
  const v1::UpdateSettingsResponse message = server::to_proto(request, *answer.value);
  ASSERT_EQ(message.clamped_size(), 1);
  EXPECT_EQ(message.clamped(0).field(), "force_limit[0]");
  EXPECT_EQ(message.clamped(0).asked(), 50.0);
  EXPECT_EQ(message.clamped(0).applied(), 10.0);
  rig.press();
  EXPECT_NEAR(rig.device->force, 0.4, 1e-9);  // 0.01 m at 40 N/m
}

TEST(Settings, MayRiseAgainWithinTheScene) {
  DeviceRig rig;
  rig.control();
  SettingsRequest request;
  request.stiffness = {40.0};
  ASSERT_TRUE(rig.sessions->update_settings("s1", request));
  request.stiffness = {90.0};
  const auto answer = rig.sessions->update_settings("s1", request);
  EXPECT_EQ(answer.value->stiffness.value[0], 90.0);
}

TEST(Settings, WrongFieldsAreNamedAndIgnored) {
  DeviceRig rig;
  rig.control();
  const auto refused = [&](const SettingsRequest& request) {
    const auto answer = rig.sessions->update_settings("s1", request);
    EXPECT_FALSE(answer);
    EXPECT_EQ(answer.refusal.code, Refusal::Code::kInvalid);
    return answer.refusal.field.str();
  };
  SettingsRequest request;
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

TEST(Settings, AreTheControllersAlone) {
  DeviceRig rig;
  rig.control();
  const auto answer = rig.sessions->update_settings("s2", {});
  EXPECT_EQ(answer.refusal.code, Refusal::Code::kPermission);
}

TEST(Settings, RendererChangesOnlyWithoutForce) {
  DeviceRig rig;
  rig.control();
  SettingsRequest request;
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

TEST(Settings, PendingEngageKeepsTheRenderer) {
  DeviceRig rig;
  rig.control();
  rig.stream(250, 0.01);
  rig.sessions->engage("s1", [](const Outcome<Done>&) {});
  SettingsRequest request;
  request.renderer = RendererKind::kStandard;
  EXPECT_FALSE(rig.sessions->update_settings("s1", request));
}

TEST(Settings, ScenesGuardCannotBeDisabled) {
  core::PipelineConfig config = rig_config();
  config.scene.direction_guard = true;
  DeviceRig rig(config);
  rig.control();
  SettingsRequest request;
  request.direction_guard = false;
  const auto answer = rig.sessions->update_settings("s1", request);
  EXPECT_EQ(answer.refusal.reason, "GUARD_REQUIRED");
}

TEST(Settings, SessionMayDisableItsOwnGuard) {
  DeviceRig rig;
  rig.control();
  SettingsRequest request;
  request.direction_guard = true;
  EXPECT_TRUE(rig.sessions->update_settings("s1", request).value->direction_guard);
  request.direction_guard = false;
  EXPECT_FALSE(rig.sessions->update_settings("s1", request).value->direction_guard);
}

TEST(Settings, ReturnToScenesAtZeroForce) {
  DeviceRig rig;
  rig.control();
  SettingsRequest request;
  request.stiffness = {40.0};
  ASSERT_TRUE(rig.sessions->update_settings("s1", request));
  rig.press();
  rig.sessions->close("s1");
  for (int i = 0; i < 200; ++i) {
    rig.tick();
    if (rig.newest().life.gain > 0.0) {
      EXPECT_EQ(rig.newest().input.settings.stiffness[0], 40.0);
    }
  }
  EXPECT_EQ(rig.newest().input.settings.stiffness[0], 100.0);
}

TEST(Settings, NewControllerStartsWithTheScenes) {
  DeviceRig rig;
  rig.control("s1");
  SettingsRequest request;
  request.stiffness = {40.0};
  ASSERT_TRUE(rig.sessions->update_settings("s1", request));
  rig.sessions->close("s1");
  rig.control("s2");
  EXPECT_EQ(rig.newest().input.settings.stiffness[0], 100.0);
}

}  // namespace
}  // namespace haptic::test
