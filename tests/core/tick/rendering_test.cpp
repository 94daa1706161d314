#include "core/src/tick/rendering.hpp"

#include <gtest/gtest.h>

#include "tests/core/tick/finger_bench.hpp"
#include "tests/support/angles.hpp"

namespace haptic::core {
namespace {

using namespace test;

/// The finger at 0.5 and 0.5 rad, and a held proxy behind it.
class RenderingTest : public testing::Test {
 protected:
  explicit RenderingTest(RendererKind kind = RendererKind::kSubspaceLinear)
      : config(config_of(kind)), model(*config.kinematics), settings{config.scene, {}} {
    sensed.ready = true;
    EXPECT_EQ(config.kinematics->inverse(joints(0.5, 0.5), sensed.q), InverseStatus::kExact);
    sample.mode = ProxyMode::kHeld;
    sample.seq = 1;
    sample.x = joints(0.47, 0.46);
  }
  PipelineConfig config;
  ProjectionModel model;
  Settings settings;
  Sensed sensed{};
  ProxySnapshot sample{};
  const VecQ unused = VecQ::Zero(2);  ///< no anchor was in use
};

TEST_F(RenderingTest, HeldProxyAnchorsByEq8) {
  Rendering rendering(model, config);
  const Anchor now = rendering.step({}, sensed, sample, settings, unused);
  VecX x_probe;
  MatXQ J;
  ASSERT_EQ(config.kinematics->evaluate(sensed.q, x_probe, J), MapStatus::kOk);
  const VecQ dq = now.q_star - sensed.q;
  EXPECT_NEAR((J * dq - (sample.x - x_probe)).norm(), 0.0, 1e-12);
  EXPECT_EQ(now.projection, ProjectionStatus::kExact);
  EXPECT_EQ(now.x_probe, x_probe);
  EXPECT_EQ(now.x, sample.x);
  EXPECT_TRUE(now.mapped && now.in_the_way && now.anchored);
  EXPECT_NEAR(now.stretch(model.layout(), sensed.q)[0], dq[0], 1e-12);
}

TEST_F(RenderingTest, FreeProxyAnchorsNothing) {
  Rendering rendering(model, config);
  sample.mode = ProxyMode::kFree;
  const Anchor now = rendering.step({}, sensed, sample, settings, unused);
  EXPECT_EQ(now.q_star, sensed.q);
  EXPECT_EQ(now.x, now.x_probe);
  EXPECT_EQ(now.projection, ProjectionStatus::kNone);
  EXPECT_FALSE(now.in_the_way || now.anchored);
  EXPECT_EQ(now.stretch(model.layout(), sensed.q)[0], 0.0);
}

TEST_F(RenderingTest, MapsNothingBeforeTheFirstSample) {
  Rendering rendering(model, config);
  sensed.ready = false;
  const Anchor now = rendering.step({}, sensed, sample, settings, unused);
  EXPECT_FALSE(now.mapped || now.anchored);
  EXPECT_EQ(now.projection, ProjectionStatus::kMapFailed);
  EXPECT_EQ(now.x_probe, VecX::Zero(2));
}

/// core/METHOD.md#map-without-a-value
TEST_F(RenderingTest, AnchorStaysIfTheMapFails) {
  for (const RendererKind kind : kEveryRenderer) {
    settings.renderer = kind;
    Rendering rendering(model, config);
    const Anchor before = rendering.step({}, sensed, sample, settings, unused);
    Sensed nowhere = sensed;
    nowhere.q << 0.02, -101 * kDegree;
    const VecQ in_use = before.q_star + joints(1e-4, 0.0);  // as the tank shortened it
    const Anchor now = rendering.step({}, nowhere, sample, settings, in_use);
    EXPECT_EQ(now.projection, ProjectionStatus::kMapFailed);
    EXPECT_EQ(now.q_star, in_use);
    EXPECT_EQ(now.x_probe, before.x_probe) << "the last one that f had";
    EXPECT_TRUE(now.anchored && now.in_the_way);
    EXPECT_FALSE(now.mapped);
  }
}

TEST_F(RenderingTest, RendererChangesWithTheSettings) {
  Rendering rendering(model, config);
  static_cast<void>(rendering.step({}, sensed, sample, settings, unused));
  settings.renderer = RendererKind::kSubspaceExact;
  const Anchor now = rendering.step({}, sensed, sample, settings, unused);
  VecQ q;
  ASSERT_EQ(config.kinematics->inverse(sample.x, q), InverseStatus::kExact);
  EXPECT_NEAR((now.q_star - q).norm(), 0.0, 1e-12) << "Eq. (6)";
}

TEST_F(RenderingTest, UnreachableProxyReportsItsClamp) {
  settings.renderer = RendererKind::kSubspaceExact;
  Rendering rendering(model, config);
  sample.x = joints(3.0, 3.0);
  const Anchor now = rendering.step({}, sensed, sample, settings, unused);
  EXPECT_EQ(now.projection, ProjectionStatus::kUnreachable);
  EXPECT_TRUE(now.limiters.has(Limiter::kRangeClamp));
}

}  // namespace
}  // namespace haptic::core
