// What a scene has the states say: passivity certificate and coupling metric.
#include "tests/server/scene/scene_text.hpp"

namespace haptic::test {
namespace {

TEST(DiagnosticsScene, AbsentMeansOff) {
  const server::Scene scene = parse(kFinger);
  EXPECT_FALSE(scene.devices[0].pipeline.passivity_certificate);
  EXPECT_FALSE(scene.devices[0].coupling_softness.has_value());
  EXPECT_EQ(scene.resolved.find("certificate"), std::string::npos);
  EXPECT_EQ(scene.resolved.find("coupling"), std::string::npos);
}

TEST(DiagnosticsScene, PresenceSelects) {
  const server::Scene scene =
      parse(with_option(kFinger, "passivity_certificate {} coupling_metric { softness: 0.2 }"));
  EXPECT_TRUE(scene.devices[0].pipeline.passivity_certificate);
  EXPECT_EQ(scene.devices[0].coupling_softness, 0.2);
  EXPECT_TRUE(server::pipeline_config(scene.devices[0], {}).passivity_certificate);
  EXPECT_EQ(parse(scene.resolved).resolved, scene.resolved);
}

TEST(DiagnosticsScene, TheSoftnessHasItsDefault) {
  const server::Scene scene = parse(with_option(kFinger, "coupling_metric {}"));
  EXPECT_EQ(scene.devices[0].coupling_softness, 0.01);
  EXPECT_NE(scene.resolved.find("softness: 0.01"), std::string::npos);
}

TEST(DiagnosticsScene, WhatIsNotAllowedIsNamed) {
  for (const char* softness : {"0", "-0.1", "nan"}) {
    const std::string error = error_of(
        with_option(kFinger, std::string("coupling_metric { softness: ") + softness + " }"));
    EXPECT_NE(error.find("coupling_metric.softness"), std::string::npos) << error;
    EXPECT_NE(error.find("> 0"), std::string::npos) << error;
  }
  EXPECT_NE(error_of(with_option(kFinger, "coupling_metric { softness: 1.5 }"))
                .find("device[0].coupling_metric.softness = 1.5: must be at most 1"),
            std::string::npos);
  EXPECT_NE(
      error_of(with_option(kLinear, "passivity_certificate {}"))
          .find("device[0].passivity_certificate = {}: must be absent where there is a prior"),
      std::string::npos)
      << error_of(with_option(kLinear, "passivity_certificate {}"));
}

}  // namespace
}  // namespace haptic::test
