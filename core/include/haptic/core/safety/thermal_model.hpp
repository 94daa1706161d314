#pragma once
/// Temperature of an actuator's winding, estimated from the force it gives, and the force that
/// keeps it below its limit. Two bodies, winding and housing, as motor data sheets describe them:
///
///   P = (tau / k_m)^2                                    copper loss, W
///   T_w -> T_h + R_w P        with the time constant t_w
///   T_h -> (R_h T_w + R_w T_ambient) / (R_w + R_h)       with t_h R_w / (R_w + R_h)
///
/// R_h = 0 keeps the housing at the ambient temperature. Each body moves exactly (an exponential)
/// over a step in which the other one and P stand still.

#include "haptic/core/time.hpp"

namespace haptic::core {

struct ThermalParameters {
  /// k_m, force per square root of lost power, N/sqrt(W) or N m/sqrt(W), through the gearing; > 0.
  /// With the winding's resistance at limit_c (copper: 0.39 % per K above 25 C), which is its
  /// largest.
  double motor_constant{1.0};
  double winding_resistance{1.0};  ///< R_w, winding to housing, K/W, > 0
  double winding_time{1.0};        ///< t_w, s, > 0
  double housing_resistance{0.0};  ///< R_h, housing to ambient, K/W, >= 0
  double housing_time{600.0};      ///< t_h, s, > 0
  double ambient_c{25.0};          ///< warmest surroundings, C
  double derate_from_c{80.0};      ///< full force up to here, C; above ambient_c
  double limit_c{100.0};           ///< the winding never passes it; above derate_from_c
};

struct ThermalState {
  double winding_c{0.0};
  double housing_c{0.0};
};

/// nullptr if the parameters are consistent; else what is wrong.
[[nodiscard]] const char* check(const ThermalParameters& parameters) noexcept;

/// The state of a motor with an unknown history: winding at derate_from_c, housing as after a long
/// time at that temperature. A restart of the server must not make a hot motor cold.
[[nodiscard]] ThermalState unknown_history(const ThermalParameters& parameters) noexcept;

/// After `dt` under the force `tau` (N or N m). dt >= 0.
[[nodiscard]] ThermalState thermal_step(const ThermalParameters& parameters, ThermalState state,
                                        double tau, Duration dt) noexcept;

/// Largest force allowed now, at most `force_limit`. Its power falls linearly with the winding's
/// temperature, from that of force_limit at derate_from_c to the one whose steady state is limit_c.
/// So the estimate stays below limit_c for ever as long as a step is short against
/// t_w (limit_c - derate_from_c) / (R_w P(force_limit)).
[[nodiscard]] double thermal_force(const ThermalParameters& parameters, const ThermalState& state,
                                   double force_limit) noexcept;

}  // namespace haptic::core
