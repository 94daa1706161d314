#include "server/owner/rights/settings_policy.hpp"

#include <algorithm>
#include <cmath>

#include "server/base/figures.hpp"

namespace haptic::server {
namespace {

/// One array of a request: each value in `value`, held within [0, limit].
std::optional<Refusal> tighten(const char* name, const Values& asked, const core::VecA& limit,
                               bool zero_allowed, core::VecA& value,
                               std::vector<std::string>& clamped) {
  if (asked.count == 0) return std::nullopt;
  if (asked.count != limit.size()) {
    return invalid_field(name, "has " + std::to_string(asked.count) + " values: must have " +
                                   std::to_string(limit.size()) + ", one per actuated DoF");
  }
  for (std::size_t i = 0; i < asked.count; ++i) {
    const std::string field = std::string(name) + "[" + std::to_string(i) + "]";
    const double wanted = asked.value[i];
    if (!std::isfinite(wanted) || !(zero_allowed ? wanted >= 0.0 : wanted > 0.0)) {
      return invalid_field(
          field, "= " + figure(wanted) + ": must be finite and " + (zero_allowed ? ">= 0" : "> 0"));
    }
    const auto k = static_cast<Eigen::Index>(i);
    value[k] = std::min(wanted, limit[k]);
    if (value[k] < wanted) {
      clamped.push_back(field + " = " + figure(wanted) + ": held at " + figure(value[k]) +
                        ", the scene allows at most this");
    }
  }
  return std::nullopt;
}

bool allows_renderer_change(core::LifecycleState state) {
  return state == core::LifecycleState::kIdle || state == core::LifecycleState::kArmed;
}

/// min(scene's, wish); Sets `refusal` if the wish is not a limit at all.
core::Duration tightened(const char* field, const Maybe<core::Duration>& wish, core::Duration scene,
                         std::optional<Refusal>& refusal) {
  if (!wish) return scene;
  if (*wish <= core::Duration::zero() && !refusal) {
    refusal = invalid_field(field, "= " + milliseconds(*wish) + ": must be > 0");
  }
  return std::min(*wish, scene);
}

}  // namespace

Outcome<SettingsAnswer> apply_settings(const SettingsRequest& request,
                                       const core::RenderSettings& current,
                                       const core::PipelineConfig& config,
                                       core::LifecycleState state) {
  const core::RenderSettings& scene = config.scene;
  SettingsAnswer answer{current, {}};
  core::RenderSettings& applied = answer.applied;
  const auto held = [&](const char* name, const Values& asked, const core::VecA& limit,
                        bool zero_allowed, core::VecA& value) {
    return tighten(name, asked, limit, zero_allowed, value, answer.clamped);
  };
  for (const auto& refusal :
       {held("stiffness", request.stiffness, scene.stiffness, true, applied.stiffness),
        held("damping", request.damping, scene.damping, true, applied.damping),
        held("force_limit", request.force_limit, scene.force_limit, true, applied.force_limit),
        held("slew_limit", request.slew_limit, scene.slew_limit, false, applied.slew_limit)}) {
    if (refusal) return *refusal;
  }
  if (request.renderer && *request.renderer != current.renderer) {
    if (!allows_renderer_change(state)) {
      return Refusal{Refusal::Code::kPrecondition,
                     "FORCE_ON",
                     "renderer: may change in IDLE and ARMED only, the device is " +
                         std::string(core::name(state)),
                     {}};
    }
    if (config.projection.coupling && !core::renders_Z_q(*request.renderer)) {
      return Refusal{
          Refusal::Code::kPrecondition,
          "STIFFNESS_COUPLED",
          "renderer: must be subspace_linear or subspace_exact, because the scene's stiffness "
          "matrix is not diagonal; asked for " +
              std::string(core::name(*request.renderer)),
          {}};
    }
    applied.renderer = *request.renderer;
  }
  if (request.direction_guard) {
    if (!*request.direction_guard && scene.direction_guard) {
      return Refusal{Refusal::Code::kPermission,
                     "GUARD_REQUIRED",
                     "direction_guard = false: the scene has the guard on, a session cannot switch "
                     "it off",
                     {}};
    }
    applied.direction_guard = *request.direction_guard;
  }
  return answer;
}

Outcome<core::StalenessLimits> lease_staleness(const LeaseRequest& request,
                                               const core::StalenessLimits& scene,
                                               std::optional<core::Duration> fresh_bound) {
  const double rate = request.nominal_rate_hz;
  if (!(rate >= 1.0 && rate <= 2000.0)) {
    return invalid_field("nominal_rate_hz",
                         "= " + figure(rate) + ": a controller or tracker must say 1..2000");
  }
  std::optional<Refusal> refusal;
  core::StalenessLimits limits;
  limits.hold_end = tightened("hold_end", request.hold_end, scene.hold_end, refusal);
  limits.fade_end = tightened("fade_end", request.fade_end, scene.fade_end, refusal);
  core::Duration fresh = core::default_fresh_end(rate);
  if (fresh_bound) fresh = std::min(fresh, *fresh_bound);
  fresh = std::min(fresh, request.fresh_end ? scene.hold_end : limits.hold_end);
  limits.fresh_end = tightened("fresh_end", request.fresh_end, fresh, refusal);
  if (refusal) return *refusal;
  if (const char* wrong = core::check(limits)) {
    return invalid_field("fresh_end, hold_end, fade_end", "= " + milliseconds(limits.fresh_end) +
                                                              ", " + milliseconds(limits.hold_end) +
                                                              ", " + milliseconds(limits.fade_end) +
                                                              ": " + wrong);
  }
  return limits;
}

}  // namespace haptic::server
