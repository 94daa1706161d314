#include "server/scene/render_scene.hpp"

#include <algorithm>

#include "haptic/core/error.hpp"
#include "server/scene/field_reader.hpp"
#include "server/scene/staleness_scene.hpp"

namespace haptic::server {
namespace {

constexpr double kSlewPerForce = 100.0;  // 1/s: the whole force in 10 ms
constexpr double kWindowPerForce = 0.25;

core::RendererKind read_renderer(v1::DeviceScene& message) {
  switch (message.renderer_case()) {
    case v1::DeviceScene::kStandard:
      return core::RendererKind::kStandard;
    case v1::DeviceScene::kNullSpace:
      return core::RendererKind::kNullSpace;
    case v1::DeviceScene::kSubspaceExact:
      return core::RendererKind::kSubspaceExact;
    case v1::DeviceScene::kSubspaceLinear:
    case v1::DeviceScene::RENDERER_NOT_SET:
      break;
  }
  message.mutable_subspace_linear();
  return core::RendererKind::kSubspaceLinear;
}

/// Z_q row by row: its diagonal as stiffness, the rest as coupling where there is any.
void read_stiffness_matrix(const v1::ImpedanceScene& message, const FieldReader& reader, int n_a,
                           RenderScene& scene) {
  if (message.stiffness_n_per_m_size() > 0) {
    reader.wrong("stiffness_matrix", "{ beside stiffness_n_per_m }",
                 "must be either stiffness_matrix or stiffness_n_per_m");
    return;
  }
  const std::vector<double> values = reader.list(
      {"stiffness_matrix", Allowed::kFinite, n_a < 0 ? -1 : n_a * n_a, "pair of actuated DoFs"});
  if (values.empty() || n_a < 0) return;
  try {
    const auto coupling = std::make_shared<const core::StiffnessCoupling>(
        Eigen::Map<const Eigen::MatrixXd>(values.data(), n_a, n_a).transpose());
    scene.settings.stiffness = coupling->scene_stiffness();
    if (!coupling->is_diagonal()) scene.coupling = coupling;
  } catch (const core::SceneError& error) {
    reader.wrong("stiffness_matrix", decimal(values), error.what());
  }
}

void read_impedance(v1::ImpedanceScene& message, const std::string& path, int n_a,
                    RenderScene& scene, Problems& problems) {
  const FieldReader reader(message, path, problems);
  core::RenderSettings& settings = scene.settings;
  if (message.stiffness_matrix_size() > 0) {
    read_stiffness_matrix(message, reader, n_a, scene);
  } else {
    settings.stiffness =
        to_vector(reader.list({"stiffness_n_per_m", Allowed::kPositive, n_a, kPerActuatedDof}));
  }
  settings.damping =
      to_vector(reader.list({"damping_n_s_per_m", Allowed::kNotNegative, n_a, kPerActuatedDof},
                            std::vector<double>(static_cast<std::size_t>(std::max(n_a, 0)))));
}

void check_effort(const FieldReader& reader, const core::VecA& force, const core::VecA& effort) {
  for (Eigen::Index i = 0; i < std::min(force.size(), effort.size()); ++i) {
    if (force[i] <= effort[i]) continue;
    reader.wrong("force_n[" + std::to_string(i) + "]", decimal(force[i]),
                 "must be at most what the device can give, " + decimal(effort[i]));
  }
}

void read_limits(v1::LimitsScene& message, const std::string& path, int n_a,
                 const core::VecA& max_effort, core::RenderSettings& settings, Problems& problems) {
  const FieldReader reader(message, path, problems);
  const std::size_t before = problems.count();
  const std::vector<double> force =
      reader.list({"force_n", Allowed::kPositive, n_a, kPerActuatedDof});
  settings.force_limit = to_vector(force);
  check_effort(reader, settings.force_limit, max_effort);
  const bool good = problems.count() == before;
  const auto times_force = [&](double factor) {
    std::vector<double> values = good ? force : std::vector<double>{};
    for (double& value : values) value *= factor;
    return values;
  };
  settings.slew_limit = to_vector(reader.list(
      {"slew_n_per_s", Allowed::kPositive, n_a, kPerActuatedDof}, times_force(kSlewPerForce)));
  settings.engage_window = to_vector(reader.list(
      {"engage_window_n", Allowed::kPositive, n_a, kPerActuatedDof}, times_force(kWindowPerForce)));
}

}  // namespace

RenderScene read_render(v1::DeviceScene& message, const std::string& path, int n_a,
                        const core::VecA& max_effort, Problems& problems) {
  RenderScene scene;
  if (message.has_impedance()) {
    read_impedance(*message.mutable_impedance(), path + ".impedance", n_a, scene, problems);
  } else {
    problems.missing(path + ".impedance", "{ stiffness_n_per_m: ... }");
  }
  if (message.has_limits()) {
    read_limits(*message.mutable_limits(), path + ".limits", n_a, max_effort, scene.settings,
                problems);
  } else {
    problems.missing(path + ".limits", "{ force_n: ... }");
  }
  const StalenessRead staleness =
      read_staleness(*message.mutable_staleness(), path + ".staleness", problems);
  scene.settings.staleness = staleness.limits;
  scene.fresh_end = staleness.fresh_end;
  scene.settings.renderer = read_renderer(message);
  scene.settings.direction_guard = message.has_direction_guard();
  if (scene.coupling && !core::renders_Z_q(scene.settings.renderer)) {
    problems.wrong(
        path + ".renderer", std::string(core::name(scene.settings.renderer)),
        "must be subspace_linear or subspace_exact beside a stiffness_matrix that is not "
        "diagonal: the others have a virtual stiffness of their own");
  }
  return scene;
}

}  // namespace haptic::server
