#include "local_proxy.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

namespace {

/// m or rad: of a simulation that reckons in single precision.
constexpr double kRounding = 1e-6;

/// s: a client that pauses is followed within this time.
constexpr double kLongestWay = 0.05;

}  // namespace

void LocalProxy::step(const ProxySnapshot& sample, const Moment& moment, const VecX& x_probe,
                      Anchor& now) noexcept {
  const double dt = seconds(moment.now - past_.time(moment.tick - 1));
  past_.push(moment.tick, moment.now, x_probe);
  const bool goes_on = sample.tenure == tenure_ && sample.mode == mode_;
  const bool same = sample.tenure == tenure_ && sample.seq == seq_ && sample.mode == mode_;
  mode_ = sample.mode;
  tenure_ = sample.tenure;
  seq_ = sample.seq;
  new_sample_ = changed_ = !same && mode_ != ProxyMode::kNone;
  error_.known = false;
  switch (mode_) {
    case ProxyMode::kHeld:
      if (new_sample_) {
        const auto free_before = free_;
        find_free(sample, goes_on);
        set_out(sample.x, goes_on, free_before, moment.now);
      }
      now.x = sample.x;
      changed_ = go_on(moment.now, dt, now.x) || new_sample_ || free_.any();
      if (free_.any()) follow(x_probe, now.x);
      last_ = now.x;
      now.in_the_way = free_.count() < static_cast<std::size_t>(space_.n_x());
      break;
    case ProxyMode::kFree:
      now.x = x_probe;
      break;
    case ProxyMode::kPlanes:
      if (new_sample_) {
        if (!goes_on) {
          projection_.forget_masses();
        } else if (began_ != 0) {
          compare(sample.anchored_at, now.x);
        }
        const bool anchored = past_.find(sample.anchored_at, used_);
        projection_.set(sample.planes, sample.x, anchored ? &used_ : nullptr);
        used_time_ = past_.time(sample.anchored_at);
        began_ = anchored && projection_.has_laws() ? sample.anchored_at : 0;
        if (began_ != 0) replay(moment, now.x);
      }
      now.planes = projection_.project(x_probe, now.x, moment.age, dt);
      now.stored = projection_.stored();
      if (now.stored > 0.0) now.coupling = projection_.coupling();
      now.unexplained = projection_.unexplained();
      now.active_planes = projection_.active();
      projection_.error(age_error(sample, moment), error_);
      now.in_the_way = changed_ = now.planes != PlaneStatus::kFree;
      break;
    case ProxyMode::kNone:
      break;
  }
}

/// Holds a coordinate again that the sample before held at the same x, even if the probe had come
/// back to it: a point that a simulation holds would else give energy at every crossing.
void LocalProxy::find_free(const ProxySnapshot& sample, bool goes_on) noexcept {
  std::bitset<kMaxX> again;
  for (Eigen::Index i = 0; goes_on && i < held_.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    again[k] = !free_[k] && sample.x[i] == held_[i];
  }
  held_ = sample.x;
  free_.reset();
  if (!past_.find(sample.seen_at, used_)) return;
  space_.difference(sample.x, used_, dx_);
  for (Eigen::Index i = 0; i < dx_.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    free_[k] = !again[k] && std::abs(dx_[i]) <= kRounding;
  }
  for (const int first : space_.quaternions()) {  // a rotation is free as a whole
    const auto k = static_cast<std::size_t>(first);
    const bool same = again[k] && again[k + 1] && again[k + 2] && again[k + 3];
    const bool whole = !same && dx_.segment<4>(first).cwiseAbs().maxCoeff() <= kRounding;
    for (int i = first; i < first + 4; ++i) free_[static_cast<std::size_t>(i)] = whole;
  }
}

void LocalProxy::follow(const VecX& x_probe, VecX& x) const noexcept {
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (free_[static_cast<std::size_t>(i)]) x[i] = x_probe[i];
  }
}

/// A coordinate that the sample before did not hold is there at once: contact is felt no later.
void LocalProxy::set_out(const VecX& to, bool goes_on, const std::bitset<kMaxX>& free_before,
                         TimePoint now) noexcept {
  way_s_ = goes_on ? std::min(seconds(now - came_), kLongestWay) : 0.0;
  came_ = now;
  if (way_s_ <= 0.0) return;
  from_ = last_;
  for (Eigen::Index i = 0; i < from_.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (free_[k] || free_before[k]) from_[i] = to[i];
  }
  space_.difference(to, from_, way_);
  if (way_.isZero(0.0)) way_s_ = 0.0;
}

bool LocalProxy::go_on(TimePoint now, double dt, VecX& x) noexcept {
  if (way_s_ <= 0.0) return false;
  const double gone_s = seconds(now - came_) + dt;
  if (gone_s < way_s_) {
    x = from_ + (gone_s / way_s_) * way_;
    for (const int first : space_.quaternions()) x.segment<4>(first).normalize();
  } else {
    way_s_ = 0.0;
  }
  return true;
}

double LocalProxy::age_error(const ProxySnapshot& sample, const Moment& moment) const noexcept {
  if (sample.planes.velocity.size() == 0) return 0.0;
  const double since_arrival = seconds(moment.now - sample.born);
  const double since_use = seconds(moment.now - used_time_);
  return std::max({moment.age - since_arrival, since_use - moment.age, 0.0});
}

/// Spends a quarter of what a replay may cost; replay() has the rest.
void LocalProxy::compare(std::uint64_t next, VecX& x) noexcept {
  if (next <= began_ || !past_.find(began_, used_) || !past_.find(next, used_)) return;
  projection_.rewind();
  run(began_, next, {.now = past_.time(began_)}, projection_.replayable() / 4, x);
}

void LocalProxy::replay(const Moment& moment, VecX& x) noexcept {
  if (began_ == moment.tick) return;
  if (!projection_.begin_at_anchor()) project_at(began_, moment, 0.0, x);
  const int steps = projection_.replayable();
  run(began_, moment.tick - 1, moment, steps - steps / 4, x);
}

void LocalProxy::run(std::uint64_t from, std::uint64_t last, const Moment& moment, int steps,
                     VecX& x) noexcept {
  const std::uint64_t stride = 1 + (last - from) / static_cast<std::uint64_t>(std::max(1, steps));
  for (std::uint64_t before = from; before != last;) {
    const std::uint64_t tick = std::min(before + stride, last);
    project_at(tick, moment, seconds(past_.time(tick) - past_.time(before)), x);
    before = tick;
  }
}

void LocalProxy::project_at(std::uint64_t tick, const Moment& moment, double dt, VecX& x) noexcept {
  if (!past_.find(tick, used_)) return;
  const double age = std::max(0.0, moment.age - seconds(moment.now - past_.time(tick)));
  static_cast<void>(projection_.project(used_, x, age, dt, 1));
}

}  // namespace haptic::core
