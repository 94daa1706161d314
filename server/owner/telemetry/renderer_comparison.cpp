#include "server/owner/telemetry/renderer_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace haptic::server {

RendererComparison::RendererComparison(std::shared_ptr<const core::Kinematics> kinematics,
                                       const core::ProjectionSettings& projection)
    : kinematics_(std::move(kinematics)), model_(*kinematics_, projection), map_(*kinematics_) {
  renderers_.reserve(core::kPaperRenderers.size());
  for (const core::RendererKind kind : core::kPaperRenderers) renderers_.emplace_back(kind, model_);
}

const std::array<core::VecA, core::kPaperRenderers.size()>& RendererComparison::evaluate(
    const core::TickRecord& record) {
  const core::DofLayout& layout = kinematics_->layout();
  for (core::VecA& tau : tau_) tau.setZero(layout.n_a());
  if (record.anchor.projection == core::ProjectionStatus::kNone ||
      record.anchor.x.size() != kinematics_->space().n_x()) {
    return tau_;
  }
  const core::BlockSet free = record.anchor.free;
  if ((map_.move_to(record.sensed.q) & ~free) != 0) {
    for (core::VecA& tau : tau_) tau.setConstant(std::numeric_limits<double>::quiet_NaN());
    return tau_;
  }
  map_.differentiate(map_.all() & ~free);
  kinematics_->space().difference(record.anchor.x, map_.x_probe(), dx_);
  map_.clear_x(free, dx_);
  const bool proxy_changed = last_x_.size() != record.anchor.x.size() || last_x_ != record.anchor.x;
  last_x_ = record.anchor.x;

  const core::VecA& stiffness = record.input.settings.stiffness;
  const core::VecA& limit = record.input.settings.force_limit;
  const core::VecA q_a = layout.select(record.sensed.q);
  if (model_.coupling()) {
    spring_.gain = record.life.gain;
    spring_.Z_q = model_.coupling()->matrix(stiffness);
    spring_.hold_within(limit);
  }
  for (std::size_t k = 0; k < core::kPaperRenderers.size(); ++k) {
    renderers_[k].project(core::Probe{record.sensed.q, map_.x_probe(), map_.J()}, record.anchor.x,
                          dx_, stiffness, proxy_changed, projection_);
    const core::VecA q_star_a = layout.select(projection_.q_star);
    if (spring_.coupled() && core::renders_Z_q(core::kPaperRenderers[k])) {
      tau_[k] = spring_.force(q_star_a - q_a);
      continue;
    }
    for (int i = 0; i < layout.n_a(); ++i) {
      const double elastic =
          record.life.gain * stiffness[i] * (q_star_a[i] - q_a[i]);  // Eq. (6), (7)
      const double most = record.life.gain * limit[i];
      tau_[k][i] = std::isfinite(elastic) ? std::clamp(elastic, -most, most) : elastic;
    }
  }
  return tau_;
}

}  // namespace haptic::server
