#include "haptic/core/safety/thermal_model.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

namespace {

double square(double v) noexcept {
  return v * v;
}

/// Share of the way to the end value that is gone after `dt`; exact, also for dt of seconds.
double approached(double dt, double time_constant) noexcept {
  return -std::expm1(-dt / time_constant);
}

double continuous_power(const ThermalParameters& p) noexcept {
  return (p.limit_c - p.ambient_c) / (p.winding_resistance + p.housing_resistance);
}

/// Where the housing would come to rest with the winding held at `winding_c`.
double housing_at_rest(const ThermalParameters& p, double winding_c) noexcept {
  return (p.housing_resistance * winding_c + p.winding_resistance * p.ambient_c) /
         (p.winding_resistance + p.housing_resistance);
}

}  // namespace

const char* check(const ThermalParameters& p) noexcept {
  const auto positive = [](double v) { return std::isfinite(v) && v > 0.0; };
  if (!positive(p.motor_constant)) return "motor_constant must be > 0";
  if (!positive(p.winding_resistance)) return "winding_resistance must be > 0";
  if (!positive(p.winding_time)) return "winding_time must be > 0";
  if (!(std::isfinite(p.housing_resistance) && p.housing_resistance >= 0.0)) {
    return "housing_resistance must be >= 0";
  }
  if (!positive(p.housing_time)) return "housing_time must be > 0";
  if (!std::isfinite(p.ambient_c) || !std::isfinite(p.limit_c)) {
    return "ambient_c and limit_c must be finite";
  }
  if (!(p.derate_from_c > p.ambient_c && p.derate_from_c < p.limit_c)) {
    return "derate_from_c must be above ambient_c and below limit_c";
  }
  return nullptr;
}

ThermalState unknown_history(const ThermalParameters& p) noexcept {
  return {p.derate_from_c, housing_at_rest(p, p.derate_from_c)};
}

ThermalState thermal_step(const ThermalParameters& p, ThermalState state, double tau,
                          Duration dt) noexcept {
  const double elapsed = seconds(dt);
  const double loss = square(tau / p.motor_constant);
  const double winding_end = state.housing_c + p.winding_resistance * loss;
  if (p.housing_resistance > 0.0) {
    const double time_constant =
        p.housing_time * p.winding_resistance / (p.winding_resistance + p.housing_resistance);
    state.housing_c += approached(elapsed, time_constant) *
                       (housing_at_rest(p, state.winding_c) - state.housing_c);
  } else {
    state.housing_c = p.ambient_c;
  }
  state.winding_c += approached(elapsed, p.winding_time) * (winding_end - state.winding_c);
  return state;
}

double thermal_force(const ThermalParameters& p, const ThermalState& state,
                     double force_limit) noexcept {
  const double lasting = continuous_power(p);
  const double peak = square(force_limit / p.motor_constant);
  if (peak <= lasting || state.winding_c <= p.derate_from_c) return force_limit;
  const double room =
      std::clamp((p.limit_c - state.winding_c) / (p.limit_c - p.derate_from_c), 0.0, 1.0);
  return p.motor_constant * std::sqrt(lasting + (peak - lasting) * room);
}

}  // namespace haptic::core
