// impedance { stiffness_matrix } of scene.proto: the coupled Z_q of core/METHOD.md#actuator-limits,
// from the text to the force.
#include <Eigen/Core>
#include <cmath>

#include "hw/simulated/linear.hpp"
#include "server/owner/telemetry/renderer_comparison.hpp"
#include "tests/server/owner/scene/scene_run.hpp"
#include "tests/server/owner/scene/scene_text.hpp"

namespace haptic::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Two actuated DoFs of damping 0.01, rendered 0.004: 2 (b - B) / T = 12.
const std::string kTwo = R"(name: "t"
device {
  name: "d"
  simulated_linear { mass: [1, 1] damping: [0.01, 0.01] max_effort: [5, 5] }
  linear {
    dof { name: "s" unit: "m" actuated: true lower: -1 upper: 1 }
    dof { name: "r" unit: "rad" actuated: true lower: -2 upper: 2 }
    coordinate { name: "x" unit: "m" }
    coordinate { name: "y" unit: "m" }
    A: [1, 0.5, 0, 1]
  }
  impedance {
    stiffness_matrix: [7, 2, 2, 6]
    damping_n_s_per_m: [0.004, 0.004]
  }
  limits { force_n: [2, 2] }
}
)";

std::string with_matrix(const std::string& values) {
  return replaced(kTwo, "[7, 2, 2, 6]", "[" + values + "]");
}

TEST(StiffnessMatrix, SplitsIntoDiagonalAndCoupling) {
  const core::VecA diagonal = (core::VecA(2) << 7.0, 6.0).finished();
  const server::Scene scene = parse(kTwo);
  const core::PipelineConfig& coupled = scene.devices[0].pipeline;
  ASSERT_NE(coupled.projection.coupling, nullptr);
  EXPECT_EQ(coupled.scene.stiffness, diagonal);
  const Eigen::Matrix2d Z = coupled.projection.coupling->matrix(diagonal);
  EXPECT_LT((Z - (Eigen::Matrix2d() << 7, 2, 2, 6).finished()).norm(), 1e-14);
  expect_resolved(scene, "stiffness_matrix: [7, 2, 2, 6]");
  EXPECT_EQ(scene.resolved.find("stiffness_n_per_m"), std::string::npos);

  const core::PipelineConfig plain = parse(with_matrix("7, 0, 0, 6")).devices[0].pipeline;
  EXPECT_EQ(plain.projection.coupling, nullptr) << "and the tick is the usual one";
  EXPECT_EQ(plain.scene.stiffness, diagonal);
}

TEST(StiffnessMatrix, ErrorsNameFieldValueAndRule) {
  EXPECT_EQ(error_of(kTwo), "no error");
  expect_each_says({
      {"size", with_matrix("7, 2, 2"),
       "t.textproto:13: device[0].impedance.stiffness_matrix = [7, 2, 2]: must have one value per "
       "pair of actuated DoFs, 4"},
      {"not symmetric", with_matrix("7, 2, 2.5, 6"), "must be finite and symmetric"},
      {"indefinite", with_matrix("7, 8, 8, 6"), "must be positive definite"},
      {"diagonal", with_matrix("7, 2, 2, -6"), "entry (1, 1) = -6.000000, must be finite and > 0"},
      {"not finite", with_matrix("7, nan, 2, 6"), "stiffness_matrix[1] = nan: must be finite"},
      {"both", replaced(kTwo, "stiffness_matrix", "stiffness_n_per_m: [7, 6] stiffness_matrix"),
       "must be either stiffness_matrix or stiffness_n_per_m"},
      {"a baseline", with_option(kTwo, "null_space {}"),
       "device[0].renderer = null_space: must be subspace_linear or subspace_exact"},
      {"none", replaced(kTwo, "stiffness_matrix: [7, 2, 2, 6]", ""),
       "device[0].impedance.stiffness_n_per_m"},
  });
}

TEST(StiffnessMatrix, FingersAreNotCoupled) {
  std::string values;
  for (int i = 0; i < 25; ++i)
    values += (i % 6 == 0 ? "700" : "10") + std::string(i < 24 ? ", " : "");
  for (const char* file : {"hand_five_fingers", "hand_tracked_palm"}) {
    std::string text = shipped_text(file);
    const std::size_t from = text.find("stiffness_n_per_m:"), to = text.find(']', from);
    ASSERT_LT(to, text.size());
    text.replace(from, to + 1 - from, "stiffness_matrix: [" + values + "]");
    expect_says(text, "must be diagonal for a hand");
  }
}

/// Each diagonal entry is below 12; only (1, 1) is too stiff: 5 + 8 = 13.
TEST(StiffnessMatrix, TheStiffestDirectionWarns) {
  EXPECT_TRUE(parse(kTwo).warnings.empty());
  const auto warnings = parse(with_matrix("8, 5, 5, 8")).warnings;
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("in its stiffest direction 1.08333"), std::string::npos)
      << warnings[0];
}

// The shipped scene.

const Matrix3d kStylus = (Matrix3d() << 7.6, 0, 0, 0, 7.9, 4, 0, 4, 3.4).finished();

struct Stylus : testing::Test {
  server::Scene scene = shipped_scene("stylus_cartesian");
  const server::DeviceScene& device = scene.devices.front();

  [[nodiscard]] core::VecQ turned(double turntable, double shoulder, double elbow) const {
    core::VecQ q = dynamic_cast<const hw::SimulatedLinearConfig&>(*device.source).target;
    q.head(3) += Vector3d(turntable, shoulder, elbow);
    return q;
  }
};

TEST_F(Stylus, TheWristIsEquallyStiff) {
  // Wrist: upper arm and forearm of 0.13 m at 0.9 and 0.9 - 1.4 rad; 200 N/m in space.
  const double a = 0.9, b = 0.9 - 1.4, l = 0.13;
  Matrix3d J = Matrix3d::Zero();  // x, y, z by turntable, shoulder, elbow
  J(1, 0) = l * (std::cos(a) + std::cos(b));
  J(0, 1) = -l * (std::sin(a) + std::sin(b));
  J(2, 1) = l * (std::cos(a) + std::cos(b));
  J(0, 2) = -l * std::sin(b);
  J(2, 2) = l * std::cos(b);
  const Matrix3d expected = 200.0 * J.transpose() * J;
  EXPECT_LT((expected - kStylus).cwiseAbs().maxCoeff(), 0.06) << expected;
  ASSERT_NE(device.pipeline.projection.coupling, nullptr);
  const Matrix3d Z = device.pipeline.projection.coupling->matrix(device.pipeline.scene.stiffness);
  EXPECT_LT((Z - kStylus).norm(), 1e-14);
}

TEST_F(Stylus, TheComparisonSaturatesLikeTheTick) {
  server::DeviceScene open = device;
  open.pipeline.passivity = {};
  server::RendererComparison comparison(open.pipeline.kinematics, open.pipeline.projection);
  SceneRun run(open);
  run.engage();
  run.hold(turned(0.08, 0.25, 0.35));
  int saturated = 0, compared = 0;
  for (int i = 0; i < 300; ++i) {
    const core::TickRecord& record = run.tick();
    const Vector3d exact(comparison.evaluate(record)[3]);
    saturated += record.limiters().has(core::Limiter::kSaturation) ? 1 : 0;
    if (record.limiters().has(core::Limiter::kSlew)) continue;
    ++compared;
    ASSERT_LT((exact - Vector3d(record.effort.tau_elastic)).norm(), 1e-9);
  }
  EXPECT_GT(compared, 200);
  EXPECT_GT(saturated, 5);
}

}  // namespace
}  // namespace haptic::test
