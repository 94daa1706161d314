#include "rendering.hpp"

namespace haptic::core {
namespace {

/// Below this no one misses a force; and share of a displacement that rounds to 0 %.
constexpr double kDeep = 1e-4, kUnfelt = 0.005;  // m or rad

}  // namespace

Rendering::Rendering(const ProjectionModel& model, const PipelineConfig& config)
    : model_(model),
      separable_(model.has_blocks() && !model.prior() && model.kinematics().blocks().size() > 1),
      map_(model.kinematics()),
      local_(model.kinematics().space(), config.projection.metric),
      renderer_(config.scene.renderer, model),
      force_error_(model),
      dx_(VecX::Zero(model.n_x())) {}

Anchor Rendering::step(const LocalProxy::Moment& moment, const Sensed& sensed,
                       const ProxySnapshot& sample, const Settings& settings,
                       const VecQ& in_use) noexcept {
  if (settings.renderer != renderer_.kind()) {
    renderer_.change(settings.renderer);
    solve_ = true;
  }
  Anchor now;
  locate(moment, sensed, sample, now);
  solve_ = solve_ || local_.changed();
  if (!now.in_the_way) {
    if (anchored_) renderer_.release();
    anchored_ = false;
    now.q_star = sensed.q;
    projection_.residual = projection_.condition = 0.0;
    projection_.contradicted = false;
    if (now.mapped) map_.differentiate(0);
  } else if (!now.mapped || !project(sensed, settings, now)) {
    // The spring stays anchored where it was, and alive. A block that was free has no spring that
    // could stay: an anchor kept would pull it while nothing holds it.
    now.q_star = anchored_ ? in_use : sensed.q;
    map_.copy_q(now.free, sensed.q, now.q_star);
    now.projection = ProjectionStatus::kMapFailed;
  }
  if (now.projection == ProjectionStatus::kUnreachable) now.limiters.set(Limiter::kRangeClamp);
  now.anchored = anchored_;
  now.residual = projection_.residual;
  now.condition = projection_.condition;
  if (local_.error().known) bound(sensed, settings, now);
  return now;
}

/// Every block's f is evaluated in every tick, but a block that nothing can hold is free: no proxy
/// and a free one hold nothing, planes hold what they name, a held proxy may be anywhere. It has
/// dx = 0 and q* = q to the bit, hence costs no J and no solve, and if its f has no value at q the
/// others do not notice (core/METHOD.md#model-only-what-a-scene-needs). A finger touched again
/// stays free until its map has a value.
void Rendering::locate(const LocalProxy::Moment& moment, const Sensed& sensed,
                       const ProxySnapshot& sample, Anchor& now) noexcept {
  const BlockSet failed = sensed.ready ? map_.move_to(sensed.q) : map_.all();
  now.x_probe = map_.x_probe();
  local_.step(sample, moment, map_.x_probe(), now);
  if (now.planes == PlaneStatus::kInfeasible) now.limiters.set(Limiter::kInfeasiblePlanes);

  BlockSet unheld = 0;
  if (separable_ && sample.mode == ProxyMode::kPlanes) {
    if (local_.new_sample()) reached_ = map_.reached(sample.planes);
    unheld = map_.all() & ~reached_;
  } else if (separable_ && sample.mode != ProxyMode::kHeld) {
    unheld = map_.all();
  }
  now.mapped = sensed.ready && (failed & ~unheld) == 0;
  now.free = free_ = unheld | (free_ & failed);
  if (now.x.size() > 0 && sample.mode != ProxyMode::kHeld) {
    map_.copy_x(unheld, now.x_probe, now.x);
  }
}

bool Rendering::project(const Sensed& sensed, const Settings& settings, Anchor& now) noexcept {
  model_.kinematics().space().difference(now.x, map_.x_probe(), dx_);
  map_.clear_x(now.free, dx_);
  has_J_ = needs_J(settings);
  map_.differentiate(has_J_);
  const ContactView contacts{local_.contacts(), &settings.force_limit};
  renderer_.project({sensed.q, map_.x_probe(), map_.J(), contacts}, now.x, dx_, settings.stiffness,
                    solve_, projection_);
  if (!projection_.q_star.allFinite()) {
    renderer_.reset();
    solve_ = true;
    return false;
  }
  solve_ = false;
  anchored_ = true;
  now.q_star = projection_.q_star;
  now.projection = projection_.status;
  if (projection_.contradicted) now.limiters.set(Limiter::kContacts);
  if (projection_.between) now.limiters.set(Limiter::kBranch);
  if (projection_.damping > 0.0) now.limiters.set(Limiter::kSingular);
  if (is_unfelt(sensed.q)) now.limiters.set(Limiter::kNotFelt);
  return true;
}

/// The springs of the motors move the tool by the mean of ||J_a|| times their stretch.
bool Rendering::is_unfelt(const VecQ& q) const noexcept {
  const bool held_back = projection_.contradicted ||
                         projection_.status == ProjectionStatus::kUnreachable ||
                         projection_.status == ProjectionStatus::kCapped;
  if (held_back || !(dx_.norm() > kDeep)) return false;
  const DofLayout& layout = model_.layout();
  const double stretch = (layout.select(projection_.q_star) - layout.select(q)).norm();
  VecX scratch;
  const double depth = model_.metric().weighed(dx_, scratch).norm();
  return stretch * model_.mean_actuated_jacobian() < kUnfelt * depth;
}

void Rendering::bound(const Sensed& sensed, const Settings& settings, Anchor& now) noexcept {
  const bool solved = now.projection == ProjectionStatus::kNone ||
                      now.projection == ProjectionStatus::kExact ||
                      now.projection == ProjectionStatus::kIllConditioned;
  if (!now.mapped || !solved) return;
  const Contacts& contacts = *local_.contacts();
  const bool exact = renderer_.kind() == RendererKind::kSubspaceExact;
  const ForceError::Renders renders{renderer_.kind(),   exact ? now.q_star : sensed.q,
                                    settings.stiffness, settings.Z_q,
                                    map_.J(),           exact || !now.in_the_way ? 0 : has_J_};
  if (!now.in_the_way) dx_.setZero();
  const Probe probe{sensed.q, map_.x_probe(), map_.J(), {&contacts, &settings.force_limit}};
  if (!force_error_.at(renders, contacts, local_.error(), now.force_error) ||
      !renderer_.widen(probe, dx_, settings.stiffness, local_.error(), now.force_error) ||
      !now.force_error.allFinite()) {
    now.force_error.resize(0);
  }
}

BlockSet Rendering::needs_J(const Settings& settings) const noexcept {
  const bool guarded = settings.direction_guard;
  if (!guarded && renderer_.reads_J(map_.all()) == 0) return 0;  // Eq. (6), whatever is displaced
  BlockSet displaced = map_.displaced(dx_);
  if (displaced != 0 && !model_.has_blocks()) displaced = map_.all();
  return guarded ? displaced | renderer_.reads_J(displaced) : renderer_.reads_J(displaced);
}

}  // namespace haptic::core
