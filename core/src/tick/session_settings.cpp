#include "session_settings.hpp"

#include <algorithm>

namespace haptic::core {

namespace {

/// Component by component the tighter of the two; what is not given stays as the scene has it.
void tighten(VecA& value, const VecA& wanted, const VecA& scene) noexcept {
  value = scene;
  if (wanted.size() != scene.size()) return;
  for (Eigen::Index i = 0; i < scene.size(); ++i) {
    if (wanted[i] >= 0.0) value[i] = std::min(wanted[i], scene[i]);
  }
}

}  // namespace

SessionSettings::SessionSettings(const RenderSettings& scene,
                                 std::shared_ptr<const StiffnessCoupling> coupling)
    : scene_(scene), coupling_(std::move(coupling)), now_{scene, {}} {
  if (coupling_) now_.Z_q = coupling_->matrix(now_.stiffness);
}

const Settings& SessionSettings::step(const RenderSettings& wanted, LifecycleState last) noexcept {
  if (wanted.id == now_.id) return now_;
  now_.id = wanted.id;
  tighten(now_.stiffness, wanted.stiffness, scene_.stiffness);
  if (coupling_) now_.Z_q = coupling_->matrix(now_.stiffness);
  tighten(now_.damping, wanted.damping, scene_.damping);
  tighten(now_.force_limit, wanted.force_limit, scene_.force_limit);
  tighten(now_.slew_limit, wanted.slew_limit, scene_.slew_limit);
  tighten(now_.engage_window, wanted.engage_window, scene_.engage_window);
  now_.direction_guard = wanted.direction_guard || scene_.direction_guard;
  now_.staleness = tightened(wanted.staleness, scene_.staleness);
  const bool offered = !coupling_ || renders_Z_q(wanted.renderer);
  if (offered && !carries_force(last)) now_.renderer = wanted.renderer;
  return now_;
}

}  // namespace haptic::core
