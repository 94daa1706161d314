// metric { W } of scene.proto: the metric of core/METHOD.md#metric-and-limits as a whole matrix.
#include <Eigen/Core>

#include "tests/server/scene/scene_run.hpp"
#include "tests/server/scene/scene_text.hpp"

namespace haptic::test {
namespace {

TEST(MetricScene, AWholeMatrixReachesTheProjectionRowByRow) {
  const server::Scene scene =
      parse(replaced(kFinger, "limits {", "metric { W: [4, 1, 1, 9] } limits {"));
  const Eigen::MatrixXd W = scene.devices[0].pipeline.projection.metric.matrix();
  EXPECT_NEAR((W - (Eigen::Matrix2d() << 4, 1, 1, 9).finished()).norm(), 0.0, 1e-14);
}

TEST(MetricScene, TheResolvedTextHoldsTheMatrixAndNoScales) {
  const server::Scene scene =
      parse(replaced(kFinger, "limits {", "metric { W: [4, 1, 1, 9] } limits {"));
  EXPECT_NE(scene.resolved.find("W: [4, 1, 1, 9]"), std::string::npos) << scene.resolved;
  EXPECT_EQ(scene.resolved.find("scale_m"), std::string::npos);
  EXPECT_EQ(parse(scene.resolved).resolved, scene.resolved);
}

TEST(MetricScene, ItMayStandWhereMetresMeetRadians) {
  const std::string mixed = replaced(
      kLinear, "A: [1, 0.5]", "coordinate { name: \"a\" unit: \"rad\" }\n A: [1, 0.5, 0, 1]");
  const std::string unneeded = replaced(mixed, "prior { weight: 0.1 sensed_stiffness: 3 }", "");
  EXPECT_EQ(error_of(replaced(unneeded, "limits {", "metric { W: [1e4, 20, 20, 1] } limits {")),
            "no error");
}

/// One actuated DoF along (1, 1), the proxy (0.01, -0.02): which error is given up is W's choice,
/// q* = 1^T W x / 1^T W 1.
TEST(MetricScene, TheRendererMeasuresByIt) {
  const std::string text = R"(name: "t"
device {
  name: "d"
  simulated_linear { mass: 1 damping: 50 hand_stiffness: 1000 max_effort: 5 }
  linear {
    dof { name: "s" unit: "m" actuated: true lower: -1 upper: 1 }
    coordinate { name: "x" unit: "m" }
    coordinate { name: "y" unit: "m" }
    A: [1, 1]
  }
  impedance { stiffness_n_per_m: 5 }
  limits { force_n: 2 }
  subspace_exact {}
  metric { W: [3, 0.5, 0.5, 1] }
}
)";
  const server::Scene scene = parse(text);
  SceneRun run(scene.devices[0]);
  run.engage();
  run.hold_at((core::VecX(2) << 0.01, -0.02).finished());
  // (3.5 0.01 - 1.5 0.02) / 5
  EXPECT_NEAR(run.run(30).q_star[0], 0.001, 1e-12);
}

}  // namespace
}  // namespace haptic::test
