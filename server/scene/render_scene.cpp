#include "server/scene/render_scene.hpp"

#include <algorithm>

#include "server/scene/field_reader.hpp"

namespace haptic::server {
namespace {

using std::chrono::milliseconds;

constexpr double kSlewPerForce = 100.0;  // 1/s: the whole force in 10 ms
constexpr double kWindowPerForce = 0.25;
/// Longer silences than this are no jitter of a network; also the longest lease
/// (WIRE 2).
constexpr core::Duration kLongestSilence{std::chrono::seconds(60)};
/// What 2.5 periods of a client are clamped to at most (WIRE 4).
constexpr core::Duration kWidestFreshEnd{milliseconds(80)};
/// Shortest fade from full force to none (WIRE 4), and the longest: a release, and so the server's
/// own end, waits for it.
constexpr core::Duration kShortestFade{milliseconds(50)};
constexpr core::Duration kLongestFade{milliseconds(1000)};

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

void read_impedance(v1::ImpedanceScene& message, const std::string& path, int n_a,
                    core::RenderSettings& settings, Problems& problems) {
  const FieldReader reader(message, path, problems);
  settings.stiffness =
      to_vector(reader.list({"stiffness_n_per_m", Allowed::kPositive, n_a, kPerActuatedDof}));
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

void read_staleness(v1::StalenessScene& message, const std::string& path, RenderScene& scene,
                    Problems& problems) {
  const FieldReader reader(message, path, problems);
  const DurationRange any{milliseconds(1), kLongestSilence};
  core::StalenessLimits& limits = scene.settings.staleness;
  const std::size_t before = problems.count();
  scene.fresh_end = reader.duration("fresh_end", any);
  limits.hold_end = reader.duration("hold_end", limits.hold_end, any);
  limits.fade_end = reader.duration("fade_end", limits.fade_end, any);
  limits.fresh_end = scene.fresh_end.value_or(std::min(kWidestFreshEnd, limits.hold_end));
  if (problems.count() > before) return;
  if (limits.fresh_end > limits.hold_end) {
    reader.wrong("fresh_end", decimal_ms(limits.fresh_end),
                 "must be at most hold_end, " + decimal_ms(limits.hold_end));
  }
  if (limits.fade_end - limits.hold_end < kShortestFade) {
    reader.wrong("fade_end", decimal_ms(limits.fade_end),
                 "must be at least hold_end + " + decimal_ms(kShortestFade) + ", " +
                     decimal_ms(limits.hold_end + kShortestFade));
  } else if (limits.fade_end - limits.hold_end > kLongestFade) {
    reader.wrong("fade_end", decimal_ms(limits.fade_end),
                 "must be at most hold_end + " + decimal_ms(kLongestFade) + ", " +
                     decimal_ms(limits.hold_end + kLongestFade));
  }
}

}  // namespace

RenderScene read_render(v1::DeviceScene& message, const std::string& path, int n_a,
                        const core::VecA& max_effort, Problems& problems) {
  RenderScene scene;
  if (message.has_impedance()) {
    read_impedance(*message.mutable_impedance(), path + ".impedance", n_a, scene.settings,
                   problems);
  } else {
    problems.missing(path + ".impedance", "{ stiffness_n_per_m: ... }");
  }
  if (message.has_limits()) {
    read_limits(*message.mutable_limits(), path + ".limits", n_a, max_effort, scene.settings,
                problems);
  } else {
    problems.missing(path + ".limits", "{ force_n: ... }");
  }
  read_staleness(*message.mutable_staleness(), path + ".staleness", scene, problems);
  scene.settings.renderer = read_renderer(message);
  scene.settings.direction_guard = message.has_direction_guard();
  return scene;
}

}  // namespace haptic::server
