#include "server/owner/telemetry/renderer_comparison.hpp"

#include <limits>
#include <utility>

#include "haptic/core/passivity/spring_storage.hpp"

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
  const core::SpringStorage diagonal{stiffness, limit, record.life.gain};
  core::SpringStorage coupled{.gain = record.life.gain};
  if (model_.coupling()) {
    coupled.Z_q = model_.coupling()->matrix(stiffness);
    coupled.hold_within(limit);
  }
  for (std::size_t k = 0; k < core::kPaperRenderers.size(); ++k) {
    renderers_[k].project(core::Probe{record.sensed.q, map_.x_probe(), map_.J()}, record.anchor.x,
                          dx_, stiffness, proxy_changed, projection_);
    const bool whole = coupled.coupled() && core::renders_Z_q(core::kPaperRenderers[k]);
    tau_[k] = (whole ? coupled : diagonal).force(layout.select(projection_.q_star) - q_a);
  }
  return tau_;
}

}  // namespace haptic::server
