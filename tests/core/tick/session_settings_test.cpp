#include "core/src/tick/session_settings.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

using std::chrono::milliseconds;

RenderSettings scene_of_two() {
  RenderSettings scene;
  scene.stiffness = two(1000.0, 500.0);
  scene.damping = two(2.0, 1.0);
  scene.force_limit = two(20.0, 10.0);
  scene.slew_limit = two(1e4, 1e3);
  scene.engage_window = two(5.0, 4.0);
  return scene;
}

RenderSettings wish(std::uint64_t id) {
  RenderSettings wanted = scene_of_two();
  wanted.id = id;
  return wanted;
}

TEST(SessionSettings, TakesEachNumberOnlyIfTighter) {
  SessionSettings settings(scene_of_two(), nullptr);
  RenderSettings wanted = wish(7);
  wanted.stiffness = two(1e9, 200.0);
  wanted.damping = two(-1.0, 0.5);
  wanted.force_limit = two(std::nan(""), 3.0);
  wanted.slew_limit = VecA::Ones(3);
  wanted.engage_window = two(0.0, 9.0);
  const Settings& now = settings.step(wanted, LifecycleState::kEngaged);
  EXPECT_EQ(now.id, 7u);
  EXPECT_EQ(now.stiffness, two(1000.0, 200.0));
  EXPECT_EQ(now.damping, two(2.0, 0.5)) << "negative: not given";
  EXPECT_EQ(now.force_limit, two(20.0, 3.0)) << "no number: not given";
  EXPECT_EQ(now.slew_limit, two(1e4, 1e3)) << "another size: not given";
  EXPECT_EQ(now.engage_window, two(0.0, 4.0));
}

TEST(SessionSettings, SameIdIsNotReadAgain) {
  SessionSettings settings(scene_of_two(), nullptr);
  RenderSettings wanted = wish(1);
  static_cast<void>(settings.step(wanted, LifecycleState::kIdle));
  wanted.stiffness = two(1.0, 1.0);
  EXPECT_EQ(settings.step(wanted, LifecycleState::kIdle).stiffness, two(1000.0, 500.0));
}

TEST(SessionSettings, ScenesGuardCannotBeSwitchedOff) {
  RenderSettings scene = scene_of_two();
  scene.direction_guard = true;
  SessionSettings guarded(scene, nullptr), open(scene_of_two(), nullptr);
  RenderSettings wanted = wish(1);
  EXPECT_TRUE(guarded.step(wanted, LifecycleState::kIdle).direction_guard);
  wanted.direction_guard = true;
  EXPECT_TRUE(open.step(wanted, LifecycleState::kIdle).direction_guard);
}

TEST(SessionSettings, StalenessIsTightenedOrTheScenes) {
  SessionSettings settings(scene_of_two(), nullptr);
  RenderSettings wanted = wish(1);
  wanted.staleness = {milliseconds(5), milliseconds(40), milliseconds(900)};
  const StalenessLimits tight = settings.step(wanted, LifecycleState::kIdle).staleness;
  EXPECT_EQ(tight, (StalenessLimits{milliseconds(5), milliseconds(40), milliseconds(180)}));
  wanted.id = 2;
  wanted.staleness.fade_end = milliseconds(41);  // does not hold together
  EXPECT_EQ(settings.step(wanted, LifecycleState::kIdle).staleness, StalenessLimits{});
}

TEST(SessionSettings, RendererStaysWhileForceIsOn) {
  for (const LifecycleState state : {LifecycleState::kArmed, LifecycleState::kEngaging,
                                     LifecycleState::kEngaged, LifecycleState::kReleasing}) {
    SessionSettings settings(scene_of_two(), nullptr);
    RenderSettings wanted = wish(1);
    wanted.renderer = RendererKind::kSubspaceExact;
    const RendererKind expected = state == LifecycleState::kArmed ? RendererKind::kSubspaceExact
                                                                  : RendererKind::kSubspaceLinear;
    EXPECT_EQ(settings.step(wanted, state).renderer, expected) << name(state);
  }
}

TEST(SessionSettings, CoupledStiffnessRefusesTheBaselines) {
  const MatAA Z_q = (MatAA(2, 2) << 1000.0, 300.0, 300.0, 500.0).finished();
  SessionSettings settings(scene_of_two(), std::make_shared<const StiffnessCoupling>(Z_q));
  RenderSettings wanted = wish(1);
  wanted.stiffness = two(250.0, 500.0);  // D C D: the coupling scales by sqrt(1/4)
  wanted.renderer = RendererKind::kStandard;
  const Settings& now = settings.step(wanted, LifecycleState::kIdle);
  EXPECT_TRUE(now.Z_q.isApprox((MatAA(2, 2) << 250.0, 150.0, 150.0, 500.0).finished(), 1e-12));
  EXPECT_EQ(now.renderer, RendererKind::kSubspaceLinear);
  EXPECT_NEAR((now.unlimited(two(0.01, -0.02)) - two(-0.5, -8.5)).norm(), 0.0, 1e-12);
  wanted.id = 2;
  wanted.stiffness = two(0.0, 1e9);  // no force, not by coupling either; at most the scene's
  const VecA uncoupled = settings.step(wanted, LifecycleState::kIdle).unlimited(two(0.01, -0.02));
  EXPECT_NEAR((uncoupled - two(0.0, -10.0)).norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace haptic::core
