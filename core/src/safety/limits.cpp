#include "haptic/core/safety/limits.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

bool within(const VecQ& v, const VecQ& lower, const VecQ& upper) noexcept {
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    if (!(v[i] >= lower[i] && v[i] <= upper[i])) return false;
  }
  return true;
}

namespace {

double held(double force, const ForceRange& range, LimiterSet& active) noexcept {
  if (force > range.upper) {
    active.set(range.upper_by);
    return range.upper;
  }
  if (force < range.lower) {
    active.set(range.lower_by);
    return range.lower;
  }
  return force;
}

}  // namespace

LimitedForce ForceLimiter::step(double elastic, double damping, double gain, double force_limit,
                                double slew, Duration dt, LimiterSet& active,
                                const ForceRange& range) noexcept {
  const bool at_rest = elastic == 0.0 && damping == 0.0 && previous_.total == 0.0 &&
                       previous_.damping == 0.0 && range.lower <= 0.0 && range.upper >= 0.0;
  if (at_rest) return previous_;  // an idle finger's, in every tick: 3 ns for 9

  const double step = slew * seconds(dt);
  LimitedForce out;

  const double damping_held = std::clamp(damping, -force_limit, force_limit);
  out.damping = std::clamp(damping_held, previous_.damping - step, previous_.damping + step);

  const double wanted = elastic + out.damping;
  const double saturated = std::clamp(wanted, -force_limit, force_limit);
  if (saturated != wanted || damping_held != damping) active.set(Limiter::kSaturation);

  const double slewed = std::clamp(saturated, previous_.total - step, previous_.total + step);
  if (slewed != saturated || out.damping != damping_held) active.set(Limiter::kSlew);
  // Damping that lags behind its slew limit may push; both parts are held, so that gain 0 still
  // means: nothing elastic.
  out.damping = held(out.damping, range, active);

  const double room = gain * force_limit;
  out.total = std::clamp(slewed, out.damping - room, out.damping + room);
  if (out.total != slewed) active.set(Limiter::kEnvelope);
  out.total = held(out.total, range, active);

  return previous_ = out;
}

}  // namespace haptic::core
