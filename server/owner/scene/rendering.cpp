// Rendering on a device: metric and limits.
#include <algorithm>
#include <cmath>

#include "haptic/core/linear/stiffness_coupling.hpp"
#include "server/base/figures.hpp"
#include "server/owner/scene/parts.hpp"

namespace haptic::server {
namespace {

constexpr double kSlewPerForce = 100.0;  // 1/s: the whole force in 10 ms
constexpr double kWindowPerForce = 0.25;

/// A longer silence is not jitter of a network; also the longest lease (proto/README.md#a-session).
constexpr core::Duration kLongestSilence{std::chrono::seconds(60)};
/// Most that 2.5 periods of a client count (proto/README.md#staleness-and-gain).
constexpr core::Duration kWidestFreshEnd{std::chrono::milliseconds(80)};
/// Shortest fade from full force to none (proto/README.md#staleness-and-gain), and the longest: a
/// release waits for it, and so does the end of hapticd.
constexpr core::Duration kShortestFade{std::chrono::milliseconds(50)};
constexpr core::Duration kLongestFade{std::chrono::milliseconds(1000)};

void check_order(const Fields& part, const core::StalenessLimits& limits) {
  if (limits.fresh_end > limits.hold_end) {
    part.wrong("fresh_end", milliseconds(limits.fresh_end),
               "must be at most hold_end, " + milliseconds(limits.hold_end));
  }
  const auto fade_must_be = [&](const char* bound, core::Duration fade) {
    part.wrong("fade_end", milliseconds(limits.fade_end),
               std::string("must be ") + bound + " hold_end + " + milliseconds(fade) + ", " +
                   milliseconds(limits.hold_end + fade));
  };
  const core::Duration fade = limits.fade_end - limits.hold_end;
  if (fade < kShortestFade) fade_must_be("at least", kShortestFade);
  if (fade > kLongestFade) fade_must_be("at most", kLongestFade);
}

/// For any x; these are the defaults.
constexpr const char* kMetricThatFits = "metric { scale_m: 0.005 scale_rad: 0.1 }";

/// `numbers` row by row as n times n.
Eigen::MatrixXd square(const Fields::Numbers& numbers, int n) {
  return Eigen::Map<const Eigen::MatrixXd>(numbers.data(), n, n).transpose();
}

core::TaskMetric read_metric(const Part<v1::MetricScene>& part,
                             const core::ConfigurationSpace& space) {
  const int n_x = space.n_x();
  if (part->w_size() > 0) {
    if (part->has_scale_m() || part->has_scale_rad()) {
      part.wrong("W", "{ with scales }", "must be either W or scale_m and scale_rad");
      return {};
    }
    const auto W = part.list({"W", Allowed::kFinite, n_x * n_x, "pair of coordinates"});
    if (W.size() == 0) return {};
    return part.attempt("W", decimal(W),
                        [&] { return core::TaskMetric::from_matrix(square(W, n_x)); });
  }
  double metres = 0.005, radians = 0.1;  // core/METHOD.md#metric-and-limits
  part.numbers(
      {{"scale_m", &metres, Allowed::kPositive}, {"scale_rad", &radians, Allowed::kPositive}});
  if (!part.good()) return {};
  core::VecX scale(n_x);
  for (int i = 0; i < n_x; ++i) {
    const core::Coordinate& coordinate = space.coordinates()[static_cast<std::size_t>(i)];
    // A chord of quaternions is half the angle between them.
    const bool half = coordinate.kind == core::CoordinateKind::kQuaternion;
    scale[i] = coordinate.unit == core::Unit::kMetre ? metres : half ? 0.5 * radians : radians;
  }
  return core::TaskMetric::from_scales(scale);
}

core::Prior read_prior(const Part<v1::PriorScene>& part, int n_n) {
  core::Prior prior;
  prior.weight = part->weight();
  if (!(std::isfinite(prior.weight) && prior.weight > 0.0)) {
    part.wrong("weight", decimal(prior.weight), "must be finite and > 0");
  }
  prior.sensed_stiffness = part.list({"sensed_stiffness", Allowed::kPositive, n_n, "sensed DoF"});
  return prior;
}

/// A prior that fits: its springs are as stiff as those of the motors, where a turn by 1 rad counts
/// as a shift by 0.1 m.
std::string prior_that_fits(const Part<v1::DeviceScene>& part, const core::Kinematics& kinematics) {
  constexpr double kLever = 0.1;  // m
  const auto in_metres = [&](core::Unit unit) { return unit == core::Unit::kMetre ? 1.0 : kLever; };
  const auto& given = part->impedance().stiffness_n_per_m();
  double stiffness = given.empty() || !(given[0] > 0.0) ? 1.0 : given[0];
  const auto& dofs = kinematics.dofs();
  const auto motor = std::find_if(dofs.begin(), dofs.end(), [](auto& dof) { return dof.actuated; });
  if (motor != dofs.end()) stiffness /= in_metres(motor->unit) * in_metres(motor->unit);
  std::string springs;
  for (const core::DofSpec& dof : dofs) {
    if (dof.actuated) continue;
    springs += (springs.empty() ? "" : ", ") +
               figure(stiffness * in_metres(dof.unit) * in_metres(dof.unit));
  }
  return "prior { weight: 1e-4 sensed_stiffness: [" + springs + "] }";
}

core::ProjectionSettings read_projection(const Part<v1::DeviceScene>& part,
                                         const core::Kinematics* kinematics) {
  core::ProjectionSettings settings;
  if (kinematics == nullptr) return settings;
  const std::size_t before = part.problems().count();
  if (part->has_metric()) {
    settings.metric = read_metric(part.part<v1::MetricScene>("metric"), kinematics->space());
  } else if (kinematics->space().mixes_units()) {
    part.missing("metric", "x holds metres and radians, which have no common distance");
  }
  if (part.problems().count() > before) part.problems().advise(kMetricThatFits);
  const std::size_t with_metric = part.problems().count();
  if (part->has_prior()) {
    settings.prior = read_prior(part.part<v1::PriorScene>("prior"), kinematics->layout().n_n());
  }
  const bool wrong = part.problems().count() > with_metric;
  if (part.problems().count() == before) {
    part.attempt("", "{ ... }",
                 [&] { core::require_rank(core::ProjectionModel(*kinematics, settings)); });
  }
  const bool absent = !part->has_prior() && part.problems().count() > with_metric;
  if (wrong || absent) part.problems().advise(prior_that_fits(part, *kinematics));
  return settings;
}

/// A renderer's message has the renderer's name.
core::RendererKind read_renderer(const Part<v1::DeviceScene>& part) {
  if (part->renderer_case() == v1::DeviceScene::RENDERER_NOT_SET) part->mutable_subspace_linear();
  const std::string chosen = part.choice("renderer");
  return *std::find_if(std::begin(core::kRenderers), std::end(core::kRenderers),
                       [&](core::RendererKind kind) { return chosen == core::name(kind); });
}

/// Z_q row by row: its diagonal becomes the stiffness, the rest, if not zero, a coupling.
void read_stiffness_matrix(const Part<v1::ImpedanceScene>& part, int n_a,
                           core::PipelineConfig& pipeline) {
  if (part->stiffness_n_per_m_size() > 0) {
    part.wrong("stiffness_matrix", "{ with stiffness_n_per_m }",
               "must be either stiffness_matrix or stiffness_n_per_m");
    return;
  }
  if (n_a < 0) return;
  const auto K =
      part.list({"stiffness_matrix", Allowed::kFinite, n_a * n_a, "pair of actuated DoFs"});
  if (K.size() == 0) return;
  part.attempt("stiffness_matrix", decimal(K), [&] {
    const auto coupling = std::make_shared<const core::StiffnessCoupling>(square(K, n_a));
    pipeline.scene.stiffness = coupling->scene_stiffness();
    if (!coupling->is_diagonal()) pipeline.projection.coupling = coupling;
  });
}

void read_impedance(const Part<v1::ImpedanceScene>& part, int n_a, core::PipelineConfig& pipeline) {
  core::RenderSettings& settings = pipeline.scene;
  if (part->stiffness_matrix_size() > 0) {
    read_stiffness_matrix(part, n_a, pipeline);
  } else {
    settings.stiffness = part.per_actuated("stiffness_n_per_m", Allowed::kPositive, n_a);
  }
  settings.damping =
      part.per_actuated("damping_n_s_per_m", Allowed::kNotNegative, n_a, filled(n_a, 0.0));
}

void read_limits(const Fields& part, int n_a, const core::VecA& effort,
                 core::RenderSettings& settings) {
  settings.force_limit = part.per_actuated("force_n", Allowed::kPositive, n_a);
  check_within_effort(part, "force_n", settings.force_limit, effort);
  const Fields::Numbers force =
      part.good() ? Fields::Numbers(settings.force_limit) : Fields::Numbers();
  settings.slew_limit =
      part.per_actuated("slew_n_per_s", Allowed::kPositive, n_a, kSlewPerForce * force);
  settings.engage_window =
      part.per_actuated("engage_window_n", Allowed::kPositive, n_a, kWindowPerForce * force);
}

/// A coupling needs a renderer that uses it, and must stay within one device's DoFs: fingers of a
/// hand are rendered one by one.
void check_coupling(const Fields& part, const core::PipelineConfig& pipeline) {
  const auto& coupling = pipeline.projection.coupling;
  if (!coupling) return;
  const core::RendererKind renderer = pipeline.scene.renderer;
  if (!core::renders_Z_q(renderer)) {
    part.wrong("renderer", std::string(core::name(renderer)),
               "must be subspace_linear or subspace_exact with a stiffness_matrix that is not "
               "diagonal: the others have a virtual stiffness of their own");
  }
  if (!pipeline.kinematics) return;
  part.part<v1::ImpedanceScene>("impedance").attempt("stiffness_matrix", "{ not diagonal }", [&] {
    core::check_coupling(*pipeline.kinematics, *coupling);
  });
}

}  // namespace

std::optional<core::Duration> read_staleness(const Part<v1::StalenessScene>& part,
                                             core::StalenessLimits& limits) {
  const DurationRange any{std::chrono::milliseconds(1), kLongestSilence};
  const std::optional<core::Duration> fresh_end = part.duration("fresh_end", any);
  limits.hold_end = part.duration("hold_end", limits.hold_end, any);
  limits.fade_end = part.duration("fade_end", limits.fade_end, any);
  limits.fresh_end = fresh_end.value_or(std::min(kWidestFreshEnd, limits.hold_end));
  if (part.good()) check_order(part, limits);
  return fresh_end;
}

void read_rendering(const Part<v1::DeviceScene>& part, DeviceScene& device) {
  core::PipelineConfig& pipeline = device.pipeline;
  const int n_a = n_a_of(device);
  pipeline.projection = read_projection(part, pipeline.kinematics.get());
  if (part->has_impedance()) {
    read_impedance(part.part<v1::ImpedanceScene>("impedance"), n_a, pipeline);
  } else {
    part.missing("impedance", "{ stiffness_n_per_m: ... }");
  }
  if (part->has_limits()) {
    read_limits(part.part<v1::LimitsScene>("limits"), n_a, effort_of(device), pipeline.scene);
  } else {
    part.missing("limits", "{ force_n: ... }");
  }
  device.fresh_end =
      read_staleness(part.part<v1::StalenessScene>("staleness"), pipeline.scene.staleness);
  pipeline.scene.renderer = read_renderer(part);
  pipeline.scene.direction_guard = part->has_direction_guard();
  check_coupling(part, pipeline);
}

}  // namespace haptic::server
