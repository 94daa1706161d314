#include <limits>

#include "stages.hpp"

namespace haptic::core {

void Pipeline::Stages::projection(TickRecord& record) noexcept {
  const BlockSet left_out = blocks_left_out();
  map_ok_ = ready_ && map_.move_to(q_, left_out);
  const VecX& x = local_proxy_.at(map_.x_probe());
  tell_proxy(x, record);
  project_anew_ = project_anew_ || local_proxy_.changed();
  projection_.status = ProjectionStatus::kNone;
  dq_a_.setZero();

  record.planes = local_proxy_.planes();
  record.active_planes = local_proxy_.active_planes();
  if (record.planes == PlaneStatus::kInfeasible) record.limiters.set(Limiter::kInfeasiblePlanes);

  if (!local_proxy_.constrained()) {
    has_anchor_ = false;
    projection_.q_star = q_;
    projection_.residual = projection_.condition = 0.0;
    if (map_ok_) map_.differentiate(0);
  } else if (!map_ok_) {
    keep_last_anchor();
  } else {
    kinematics_.space().difference(x, map_.x_probe(), dx_);
    map_.fill(map_.unprobed(), 0.0, dx_);  // and q* = q: nothing is in their way
    map_.differentiate(needs_J() & ~map_.unprobed());
    const VecQ last_anchor = projection_.q_star;
    renderer_.project(Probe{q_, map_.x_probe(), map_.J()}, x, dx_, settings_.stiffness,
                      project_anew_, projection_);
    if (all_finite(projection_.q_star)) {
      project_anew_ = false;
      has_anchor_ = true;
    } else {
      projection_.q_star = last_anchor;
      renderer_.reset();
      project_anew_ = true;
      keep_last_anchor();
    }
  }
  if (has_anchor_) dq_a_ = layout_.select(projection_.q_star) - layout_.select(q_);
  if (certificate_) certify(record);
}

/// core/METHOD.md#model-only-what-a-scene-needs, "model only what a scene needs". A held proxy can
/// be anywhere; no proxy and a free one hold nothing; planes hold what they name.
BlockSet Pipeline::Stages::blocks_left_out() noexcept {
  if (!leaves_out_) return 0;
  switch (local_proxy_.mode()) {
    case ProxyMode::kHeld:
      return 0;
    case ProxyMode::kPlanes:
      if (local_proxy_.pending()) reached_ = map_.reached(local_proxy_.sample().planes);
      return map_.all() & ~reached_;
    case ProxyMode::kFree:
    case ProxyMode::kNone:
      break;
  }
  return map_.all();
}

void Pipeline::Stages::tell_proxy(const VecX& x, TickRecord& record) const noexcept {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  record.x_probe = map_.x_probe();
  record.x = x;
  record.unprobed = map_.unprobed();
  map_.fill(record.unprobed, kNone, record.x_probe);
  const bool follows = x.size() > 0 && local_proxy_.mode() != ProxyMode::kHeld;
  if (follows) map_.fill(record.unprobed, kNone, record.x);
}

void Pipeline::Stages::certify(TickRecord& record) noexcept {
  CertificateStatus& status = record.certificate.status;
  if (!local_proxy_.constrained()) {
    status = CertificateStatus::kIdle;
  } else if (projection_.status == ProjectionStatus::kMapFailed) {
    status = CertificateStatus::kMapFailed;
  } else if (renderer_.kind() != RendererKind::kSubspaceLinear) {
    status = CertificateStatus::kOtherRenderer;
  } else {
    const Probe probe{q_, map_.x_probe(), map_.J()};
    record.certificate = certificate_->at(probe, dx_, settings_.stiffness);
  }
}

BlockSet Pipeline::Stages::needs_J() const noexcept {
  if (envelope_) return map_.all();
  const bool guarded = settings_.direction_guard || config_.monotone_envelope;
  if (!guarded && renderer_.reads_J(map_.all()) == 0) return 0;  // Eq. (6), whatever is displaced
  BlockSet displaced = map_.displaced(dx_);
  if (displaced != 0 && !model_.has_parts()) displaced = map_.all();
  return guarded ? displaced | renderer_.reads_J(displaced) : renderer_.reads_J(displaced);
}

/// core/METHOD.md#map-without-a-value: f has no value here; the spring stays anchored where it was,
/// and alive. A block that was left out has no spring that could stay: an anchor kept would pull it
/// where it is free.
void Pipeline::Stages::keep_last_anchor() noexcept {
  if (!has_anchor_) projection_.q_star = q_;
  map_.copy_q(map_.unprobed(), q_, projection_.q_star);
  projection_.status = ProjectionStatus::kMapFailed;
}

}  // namespace haptic::core
