// What is rendered on a device, in which metric, and within which limits.
#include <algorithm>
#include <cmath>

#include "haptic/core/error.hpp"
#include "haptic/core/linear/stiffness_coupling.hpp"
#include "server/base/figures.hpp"
#include "server/scene/parts.hpp"
#include "server/scene/reader.hpp"

namespace haptic::server {
namespace {

constexpr double kSlewPerForce = 100.0;  // 1/s: the whole force in 10 ms
constexpr double kWindowPerForce = 0.25;

/// A longer silence is not jitter of a network; also the longest lease (proto/README.md#a-session).
constexpr core::Duration kLongestSilence{std::chrono::seconds(60)};
/// What 2.5 periods of a client are clamped to at most (proto/README.md#staleness-and-gain).
constexpr core::Duration kWidestFreshEnd{std::chrono::milliseconds(80)};
/// Shortest fade from full force to none (proto/README.md#staleness-and-gain), and the longest: a
/// release waits for it, and so does the end of hapticd.
constexpr core::Duration kShortestFade{std::chrono::milliseconds(50)};
constexpr core::Duration kLongestFade{std::chrono::milliseconds(1000)};

void check_order(const FieldReader& reader, const core::StalenessLimits& limits) {
  if (limits.fresh_end > limits.hold_end) {
    reader.wrong("fresh_end", milliseconds(limits.fresh_end),
                 "must be at most hold_end, " + milliseconds(limits.hold_end));
  }
  if (limits.fade_end - limits.hold_end < kShortestFade) {
    reader.wrong("fade_end", milliseconds(limits.fade_end),
                 "must be at least hold_end + " + milliseconds(kShortestFade) + ", " +
                     milliseconds(limits.hold_end + kShortestFade));
  } else if (limits.fade_end - limits.hold_end > kLongestFade) {
    reader.wrong("fade_end", milliseconds(limits.fade_end),
                 "must be at most hold_end + " + milliseconds(kLongestFade) + ", " +
                     milliseconds(limits.hold_end + kLongestFade));
  }
}

core::TaskMetric read_matrix(v1::MetricScene& message, const FieldReader& reader, int n_x) {
  if (message.has_scale_m() || message.has_scale_rad()) {
    reader.wrong("W", "{ beside scales }", "must be either W or scale_m and scale_rad");
    return {};
  }
  const std::vector<double> values =
      reader.list({"W", Allowed::kFinite, n_x * n_x, "pair of coordinates"});
  if (values.empty()) return {};
  try {
    return core::TaskMetric::from_matrix(
        Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
            values.data(), n_x, n_x));
  } catch (const core::SceneError& error) {
    reader.wrong("W", decimal(values), error.what());
    return {};
  }
}

core::TaskMetric read_metric(v1::MetricScene& message, const std::string& path,
                             const core::ConfigurationSpace& space, Problems& problems) {
  const std::size_t before = problems.count();
  const FieldReader reader(message, path, problems);
  if (message.w_size() > 0) return read_matrix(message, reader, space.n_x());
  double metres = 0.005, radians = 0.1;  // core/METHOD.md#metric-and-limits
  reader.numbers(
      {{"scale_m", &metres, Allowed::kPositive}, {"scale_rad", &radians, Allowed::kPositive}});
  if (problems.count() > before) return {};
  core::VecX scale(space.n_x());
  for (int i = 0; i < space.n_x(); ++i) {
    const core::Coordinate& coordinate = space.coordinates()[static_cast<std::size_t>(i)];
    // A chord of quaternions is half the angle between them.
    const bool half = coordinate.kind == core::CoordinateKind::kQuaternion;
    scale[i] = coordinate.unit == core::Unit::kMetre ? metres : half ? 0.5 * radians : radians;
  }
  return core::TaskMetric::from_scales(scale);
}

core::Prior read_prior(v1::PriorScene& message, const std::string& path, int n_n,
                       Problems& problems) {
  const FieldReader reader(message, path, problems);
  core::Prior prior;
  prior.weight = message.weight();
  if (!(std::isfinite(prior.weight) && prior.weight > 0.0)) {
    reader.wrong("weight", decimal(prior.weight), "must be finite and > 0");
  }
  prior.sensed_stiffness =
      to_vector(reader.list({"sensed_stiffness", Allowed::kPositive, n_n, "sensed DoF"}));
  return prior;
}

core::ProjectionSettings read_projection(v1::DeviceScene& message, const std::string& path,
                                         const core::Kinematics* kinematics, Problems& problems) {
  core::ProjectionSettings settings;
  if (kinematics == nullptr) return settings;
  const std::size_t before = problems.count();
  if (message.has_metric()) {
    settings.metric =
        read_metric(*message.mutable_metric(), path + ".metric", kinematics->space(), problems);
  } else if (kinematics->space().mixes_units()) {
    problems.missing(path + ".metric", "x holds metres and radians, which have no common distance");
  }
  if (message.has_prior()) {
    settings.prior =
        read_prior(*message.mutable_prior(), path + ".prior", kinematics->layout().n_n(), problems);
  }
  if (problems.count() > before) return settings;
  try {
    core::require_rank(core::ProjectionModel(*kinematics, settings));
  } catch (const core::SceneError& error) {
    problems.wrong(path, "{ ... }", error.what());
  }
  return settings;
}

/// A renderer's message has the renderer's name.
core::RendererKind read_renderer(v1::DeviceScene& message) {
  const auto* const choice = message.GetDescriptor()->FindOneofByName("renderer");
  const auto* const chosen = message.GetReflection()->GetOneofFieldDescriptor(message, choice);
  for (const core::RendererKind kind : core::kRenderers) {
    if (chosen != nullptr && chosen->name() == core::name(kind)) return kind;
  }
  message.mutable_subspace_linear();
  return core::RendererKind::kSubspaceLinear;
}

/// Z_q row by row: its diagonal becomes the stiffness, the rest, if not zero, a coupling.
void read_stiffness_matrix(const v1::ImpedanceScene& message, const FieldReader& reader, int n_a,
                           core::PipelineConfig& pipeline) {
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
    pipeline.scene.stiffness = coupling->scene_stiffness();
    if (!coupling->is_diagonal()) pipeline.projection.coupling = coupling;
  } catch (const core::SceneError& error) {
    reader.wrong("stiffness_matrix", decimal(values), error.what());
  }
}

void read_impedance(v1::ImpedanceScene& message, const std::string& path, int n_a,
                    core::PipelineConfig& pipeline, Problems& problems) {
  const FieldReader reader(message, path, problems);
  core::RenderSettings& settings = pipeline.scene;
  if (message.stiffness_matrix_size() > 0) {
    read_stiffness_matrix(message, reader, n_a, pipeline);
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
    reader.wrong(entry("force_n", static_cast<std::size_t>(i)), decimal(force[i]),
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

/// A coupling needs a renderer that uses it, and must stay within one device's DoFs: fingers of a
/// hand are rendered one by one.
void check_coupling(const std::string& path, const core::PipelineConfig& pipeline,
                    Problems& problems) {
  const auto& coupling = pipeline.projection.coupling;
  if (!coupling) return;
  const core::RendererKind renderer = pipeline.scene.renderer;
  if (!core::renders_Z_q(renderer)) {
    problems.wrong(
        path + ".renderer", std::string(core::name(renderer)),
        "must be subspace_linear or subspace_exact beside a stiffness_matrix that is not "
        "diagonal: the others have a virtual stiffness of their own");
  }
  try {
    if (pipeline.kinematics) core::check_coupling(*pipeline.kinematics, *coupling);
  } catch (const core::SceneError& error) {
    problems.wrong(path + ".impedance.stiffness_matrix", "{ not diagonal }", error.what());
  }
}

}  // namespace

std::optional<core::Duration> read_staleness(v1::StalenessScene& message, const std::string& path,
                                             core::StalenessLimits& limits, Problems& problems) {
  const FieldReader reader(message, path, problems);
  const DurationRange any{std::chrono::milliseconds(1), kLongestSilence};
  const std::size_t before = problems.count();
  const std::optional<core::Duration> fresh_end = reader.duration("fresh_end", any);
  limits.hold_end = reader.duration("hold_end", limits.hold_end, any);
  limits.fade_end = reader.duration("fade_end", limits.fade_end, any);
  limits.fresh_end = fresh_end.value_or(std::min(kWidestFreshEnd, limits.hold_end));
  if (problems.count() == before) check_order(reader, limits);
  return fresh_end;
}

void read_rendering(v1::DeviceScene& message, const std::string& path, DeviceScene& device,
                    Problems& problems) {
  core::PipelineConfig& pipeline = device.pipeline;
  const int n_a = n_a_of(pipeline.kinematics.get());
  pipeline.projection = read_projection(message, path, pipeline.kinematics.get(), problems);
  if (message.has_impedance()) {
    read_impedance(*message.mutable_impedance(), path + ".impedance", n_a, pipeline, problems);
  } else {
    problems.missing(path + ".impedance", "{ stiffness_n_per_m: ... }");
  }
  if (message.has_limits()) {
    read_limits(*message.mutable_limits(), path + ".limits", n_a,
                device.source ? device.source->effort() : core::VecA{}, pipeline.scene, problems);
  } else {
    problems.missing(path + ".limits", "{ force_n: ... }");
  }
  device.fresh_end = read_staleness(*message.mutable_staleness(), path + ".staleness",
                                    pipeline.scene.staleness, problems);
  pipeline.scene.renderer = read_renderer(message);
  pipeline.scene.direction_guard = message.has_direction_guard();
  pipeline.monotone_envelope = message.has_monotone_envelope();
  check_coupling(path, pipeline, problems);
}

}  // namespace haptic::server
