#include "rendered_spring.hpp"

#include <algorithm>

namespace haptic::core {

namespace {

/// Several fingers, no prior and a diagonal Z_q: Eq. (8) is Z_q S J^+ dx, and Eq. (15) a sum of
/// squares by Z_q.
bool keeps_guard(const ProjectionModel& model) noexcept {
  const bool fingers =
      model.has_blocks() ? model.blocks().size() > 1 : model.kinematics().mechanisms().size() > 1;
  return fingers && !model.prior() && !model.coupling();
}

}  // namespace

RenderedSpring::RenderedSpring(const ProjectionModel& model, const PipelineConfig& config)
    : layout_(model.layout()),
      device_damping_(config.passivity.device_damping.size() > 0 ? config.passivity.device_damping
                                                                 : VecA(VecA::Zero(layout_.n_a()))),
      hold_(seconds(config.device.sample_period)),
      by_sum_(keeps_guard(model)),
      guard_(model, config.scene.stiffness),
      stretch_(VecA::Zero(layout_.n_a())),
      displayed_(VecA::Ones(layout_.n_a())),
      elastic_(stretch_) {
  if (config.passivity.enabled()) passivity_.emplace(config.passivity, layout_.n_a());
  if (model.coupling()) coupled_.emplace();
}

void RenderedSpring::step(const Beat& beat, const Sensed& sensed, const Anchor& wanted,
                          const Lifecycle& life, const Settings& settings, const Displacement& at,
                          const VecA& force_limit, Effort& effort) noexcept {
  q_star_ = wanted.q_star;
  stretch_ = wanted.stretch(layout_, sensed.q);
  if (coupled_) {
    coupled_->gain = 1.0;
    coupled_->stiffness = settings.stiffness;
    coupled_->Z_q = settings.Z_q;
    weakest_ = coupled_->hold_within(force_limit);
  }
  const bool pulls = wanted.anchored && wanted.mapped;
  const bool taken_off = pulls && withheld(sensed, wanted, settings, at, effort);
  if (passivity_) {
    pay(beat, sensed, wanted, life, settings, at, taken_off || !wanted.anchored, effort);
  }
  elastic_ = force(settings);
  effort.q_star = q_star_;
}

VecA RenderedSpring::force(const Settings& settings) const noexcept {
  return coupled_ ? coupled_->force(stretch_) : settings.unlimited(stretch_);
}

int RenderedSpring::saturated() const noexcept {
  if (weakest_ < 0 || !(coupled_->length(stretch_) > coupled_->radius)) return -1;
  return weakest_;
}

void RenderedSpring::hold(const Effort& effort) noexcept {
  if (passivity_) passivity_->hold(effort.tau_elastic, effort.tau_damping);
}

bool RenderedSpring::withheld(const Sensed& sensed, const Anchor& wanted, const Settings& settings,
                              const Displacement& at, Effort& effort) noexcept {
  const bool guarded = settings.direction_guard &&
                       settings.renderer != RendererKind::kPerContact;  // has a rule of its own
  const bool towards = by_sum_ && settings.renderer == RendererKind::kSubspaceLinear &&
                       wanted.projection == ProjectionStatus::kExact;
  if (!guarded || towards || guard_.allows(at.probe, at.dx, force(settings))) return false;
  effort.limiters.set(Limiter::kDirectionGuard);
  stretch_.setZero();
  for (int i = 0; i < layout_.n_a(); ++i) {
    q_star_[layout_.actuated(i)] = sensed.q[layout_.actuated(i)];
  }
  return true;
}

/// The spring in the book has the force of the rendered one, but from a nearer anchor and with a
/// stiffness `displayed_` times as high: as stiff as the user can feel it. Any such factor keeps
/// the book exact; with 1 a baseline that displays three times Z_q is throttled in a plain press,
/// for energy that the user did put in.
void RenderedSpring::pay(const Beat& beat, const Sensed& sensed, const Anchor& wanted,
                         const Lifecycle& life, const Settings& settings, const Displacement& at,
                         bool off, Effort& effort) noexcept {
  if (life.engaged) {
    passivity_->restart();
    coupling_ = 0.0;
  }
  const VecA q_a = layout_.select(sensed.q);
  passivity_->measure(q_a, sensed.fresh, sensed.recent, beat.dt, sensed.tau_measured);
  SpringStorage spring;
  if (coupled_) {
    spring = *coupled_;  // of the subspace methods only: they display Z_q
  } else {
    if (!off && wanted.mapped) find_displayed(settings, at);
    spring.stiffness = settings.stiffness.cwiseProduct(displayed_);
    spring.limit = settings.force_limit;
  }
  // A spring that is not there stores nothing over the tick either, however far the device moves.
  spring.gain = off ? 0.0 : life.gain;
  VecA anchor = off ? q_a : layout_.select(q_star_);
  for (int i = 0; i < layout_.n_a(); ++i) {  // a factor of 1 leaves the anchor's bits alone
    if (displayed_[i] != 1.0) anchor[i] = q_a[i] + (anchor[i] - q_a[i]) / displayed_[i];
  }
  // The contacts' energy is known by the stiffness of the coupling between x and x_probe, which the
  // spring displays; an object that flies has what it was given.
  if (wanted.stored > 0.0 && wanted.coupling > 0.0 && !off) {
    coupling_ = spring.energy(VecA(anchor - q_a)) / wanted.coupling;
  }
  anchor = passivity_->admit(spring, anchor, wanted.stored * coupling_, settings.slew_limit);
  effort.passivity = passivity_->record();
  for (int i = 0; i < layout_.n_a() && !off; ++i) {
    double& q_star = q_star_[layout_.actuated(i)];
    if (displayed_[i] == 1.0) {
      q_star = anchor[i];
    } else if (effort.passivity.throttled) {
      q_star = q_a[i] + displayed_[i] * (anchor[i] - q_a[i]);
    }
    stretch_[i] = q_star - q_a[i];
  }
  if (effort.passivity.throttled) effort.limiters.set(Limiter::kEnergyTank);
  // While nothing is in the way there is no drag, whatever the book says.
  if (wanted.anchored && life.damping_gain > 0.0) {
    controller_ = passivity_->controller();
    if (effort.passivity.alpha > 0.0) effort.limiters.set(Limiter::kPassivity);
  } else {
    controller_.setZero(layout_.n_a());
    effort.passivity.alpha = 0.0;
  }
}

/// At least Z_q, and no more than the device's own damping pays the hold's leak of
/// (core/METHOD.md#sampled-data: b > K T / 2).
void RenderedSpring::find_displayed(const Settings& settings, const Displacement& at) noexcept {
  at.renderer.displayed_bound(at.probe, at.dx, settings.stiffness, displayed_);
  for (int i = 0; i < layout_.n_a(); ++i) {
    const double paid = 2.0 * device_damping_[i] / hold_;
    displayed_[i] = std::clamp(displayed_[i], 1.0, std::max(1.0, paid / settings.stiffness[i]));
  }
}

}  // namespace haptic::core
