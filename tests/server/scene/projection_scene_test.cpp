#include "server/scene/projection_scene.hpp"

#include "tests/server/scene/scene_text.hpp"

namespace haptic::test {
namespace {

/// kLinear with its prior replaced, and a second coordinate where `second` is given.
std::string scene(const std::string& projection, const std::string& second = "") {
  std::string text = kLinear;
  const std::string prior = "prior { weight_per_j: 0.001 sensed_stiffness: 1 }";
  text.replace(text.find(prior), prior.size(), projection);
  if (!second.empty()) {
    const std::string A = "A: [1, 0.5]";
    text.replace(text.find(A), A.size(), second + "\n    A: [1, 0.5, 0.2, 1]");
  }
  return text;
}

const std::string kMetres = R"(coordinate { name: "y" unit: "m" })";
const std::string kRadians = R"(coordinate { name: "a" unit: "rad" })";

TEST(ProjectionScene, PresenceSelects) {
  const auto plain = parse(scene("", kMetres)).devices[0].projection;
  EXPECT_TRUE(plain.metric.is_identity());
  EXPECT_FALSE(plain.prior.has_value());
  EXPECT_TRUE(parse(kFinger).devices[0].projection.metric.is_identity());
  const auto both =
      parse(scene("task_metric { scale: 0.005 } prior { weight_per_j: 2 sensed_stiffness: 3 }"))
          .devices[0]
          .projection;
  ASSERT_TRUE(both.prior.has_value());
  EXPECT_EQ(both.prior->weight, 2.0);
  ASSERT_EQ(both.prior->sensed_stiffness.size(), 1);
  EXPECT_EQ(both.prior->sensed_stiffness[0], 3.0);
  core::VecX error = core::VecX::Constant(1, 0.01);
  both.metric.weigh(error);
  EXPECT_DOUBLE_EQ(error[0], 2.0) << "10 mm are two of 5 mm";
}

TEST(ProjectionScene, MetresAndRadiansNeedAMetricAndOneUnitDoesNot) {
  EXPECT_EQ(error_of(scene("", kMetres)), "no error");
  EXPECT_NE(error_of(scene("", kRadians))
                .find("t.textproto:2: device[0].task_metric: is required: { scale: ... }"),
            std::string::npos);
  EXPECT_EQ(error_of(scene("task_metric { scale: [0.005, 0.1] }", kRadians)), "no error");
  const auto full = parse(scene("task_metric { matrix: [4, 1, 1, 9] }", kRadians));
  core::VecX dx = (core::VecX(2) << 1.0, 2.0).finished();
  full.devices[0].projection.metric.weigh(dx);
  EXPECT_NEAR(dx.squaredNorm(), 4.0 + 2.0 * 2.0 + 9.0 * 4.0, 1e-12) << "dx^T W dx";
}

TEST(ProjectionScene, WhatXDoesNotDetermineNeedsAPrior) {
  EXPECT_NE(error_of(scene("")).find("device[0].prior = [absent]: prior: must be given"),
            std::string::npos);
  EXPECT_EQ(error_of(kLinear), "no error");
}

TEST(ProjectionScene, MistakesAreNamed) {
  const auto expect = [](const std::string& text, const std::string& part) {
    EXPECT_NE(error_of(text).find(part), std::string::npos) << error_of(text);
  };
  expect(scene("prior {}"), "device[0].prior.weight_per_j: is required");
  expect(scene("prior { weight_per_j: 1 }"), "device[0].prior.sensed_stiffness: is required");
  expect(scene("prior { weight_per_j: -1 sensed_stiffness: 1 }"),
         "device[0].prior.weight_per_j = -1: must be > 0");
  expect(scene("prior { weight_per_j: 1 sensed_stiffness: 0 }"),
         "device[0].prior.sensed_stiffness[0] = 0: must be > 0");
  expect(scene("task_metric {}", kMetres), "device[0].task_metric: is required: one of");
  expect(scene("task_metric { scale: 1 }", kMetres),
         "device[0].task_metric.scale = [1]: must have one value per coordinate, 2");
  expect(scene("task_metric { scale: [1, 0] }", kMetres),
         "device[0].task_metric.scale[1] = 0: must be > 0");
  expect(scene("task_metric { matrix: [1, 2, 2, 1] }", kMetres),
         "device[0].task_metric = { ... }: task metric: must be positive definite");
  std::string finger = kFinger;
  finger.insert(finger.rfind('}'), "prior { weight_per_j: 1 sensed_stiffness: 1 }\n");
  expect(finger, "device[0].prior = { ... }: prior: must be absent");
}

}  // namespace
}  // namespace haptic::test
