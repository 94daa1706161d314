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
      eased_(layout_.n_a()),
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
  const bool held_back = pulls && at.q_wish != nullptr;
  const VecA wish =
      held_back ? VecA(layout_.select(*at.q_wish) - layout_.select(sensed.q)) : stretch_;
  const double share = pulls ? guarded(wanted, settings, at) : 1.0;
  if (life.engaged) eased_.restart();
  bool taken_off = false;
  if (held_back || share < 1.0 || !eased_.whole()) {
    taken_off = ease(beat, sensed, wish, share, settings, force_limit, effort);
  } else {
    eased_.follow(limited(stretch_, settings, force_limit));
  }
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

double RenderedSpring::guarded(const Anchor& wanted, const Settings& settings,
                               const Displacement& at) noexcept {
  const bool guarded = settings.direction_guard &&
                       settings.renderer != RendererKind::kPerContact;  // has a rule of its own
  const bool towards = by_sum_ && settings.renderer == RendererKind::kSubspaceLinear &&
                       wanted.projection == ProjectionStatus::kExact;
  return guarded && !towards ? guard_.share(at.probe, at.dx, force(settings)) : 1.0;
}

VecA RenderedSpring::limited(const VecA& stretch, const Settings& settings,
                             const VecA& force_limit) const noexcept {
  if (coupled_) return coupled_->force(stretch);
  return settings.stiffness.cwiseProduct(stretch).cwiseMin(force_limit).cwiseMax(-force_limit);
}

bool RenderedSpring::ease(const Beat& beat, const Sensed& sensed, const VecA& wish, double share,
                          const Settings& settings, const VecA& force_limit,
                          Effort& effort) noexcept {
  const VecA wished = limited(wish, settings, force_limit);
  const VecA allowed = share * limited(stretch_, settings, force_limit);
  const VecA& used = eased_.step(wished, allowed, force_limit, seconds(beat.dt));
  if (eased_.whole()) return false;
  effort.limiters.set(settings.renderer == RendererKind::kPerContact ? Limiter::kContacts
                                                                     : Limiter::kDirectionGuard);
  if (used == allowed && share == 1.0) return false;
  const VecA& K = settings.stiffness;
  double most = 0.0;  // share of a coupled spring
  for (int i = 0; i < layout_.n_a(); ++i) {
    if (wished[i] != 0.0) most = std::max(most, std::min(1.0, used[i] / wished[i]));
    if (!coupled_) stretch_[i] = K[i] > 0.0 ? used[i] / K[i] : 0.0;
  }
  if (coupled_) stretch_ = most * wish;
  const bool none = (stretch_.array() == 0.0).all();
  for (int i = 0; i < layout_.n_a(); ++i) {
    const int k = layout_.actuated(i);
    q_star_[k] = none ? sensed.q[k] : sensed.q[k] + stretch_[i];
  }
  return none;
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
  const bool ahead = sensed.ahead.size() > 0;
  const VecA read = ahead ? VecA(q_a + sensed.ahead) : q_a;
  passivity_->measure(read, sensed.fresh, sensed.recent, beat.dt, sensed.tau_measured);
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
  // The book has q_a as it was read. The spring is as long there as by the low-passed one.
  if (ahead) anchor += sensed.ahead;
  // The contacts' energy is known by the stiffness of the coupling between x and x_probe, which the
  // spring displays; an object that flies has what it was given.
  if (wanted.stored > 0.0 && wanted.coupling > 0.0 && !off) {
    coupling_ = spring.energy(VecA(anchor - read)) / wanted.coupling;
  }
  anchor = passivity_->admit(spring, anchor, wanted.stored * coupling_, settings.slew_limit);
  if (ahead) anchor -= sensed.ahead;
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
