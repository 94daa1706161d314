#pragma once
/// The passivity observer and controller, exact for a zero-order hold
/// (core/METHOD.md#passivity-observer): the observer counts the energy that the held force took
/// from the user beyond what the spring stores. If that falls below what is allowed, the controller
/// adds just the damping that makes up for it.

#include "haptic/core/passivity/energy_tank.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

struct ObserverSettings {
  bool enabled{false};
  double allowance{0.0};      ///< E0, J, >= 0
  double forgetting{0.5e-3};  ///< J: credit beyond this is dropped
  VecA inertia{};             ///< M_a, n_a, > 0: the device's own, kg or kg m^2; bounds alpha
  VecA slowest{};             ///< v_min, n_a, about 2 quanta per period, m/s or rad/s; size 0: none
};

class PassivityObserver {
 public:
  PassivityObserver(const ObserverSettings& settings, int n_a);

  void restart() noexcept;
  /// E_obs += what the last hold took; then alpha for the motion dq (n_a) over T (s), with D =
  /// Z_q of the spring: alpha = min(-(E_obs + E0) / (T v^T D v), alpha_max). D diagonal: alpha_max
  /// K_i / M_i <= 1/(2T); coupled: alpha_max ||M_a^{-1/2} D M_a^{-1/2}||_inf <= 1/(2T), which
  /// bounds the eigenvalue of core/METHOD.md#passivity-observer.
  void observe(const HoldAccount& account, const VecA& dq, double T,
               const SpringStorage& spring) noexcept;
  /// The rate is no longer known: no controller.
  void release() noexcept;

  [[nodiscard]] double energy() const noexcept { return energy_; }  ///< E_obs, J
  [[nodiscard]] double alpha() const noexcept { return alpha_; }    ///< s
  /// -alpha D v, n_a, to be added to the damping; stays until the next sample.
  [[nodiscard]] const VecA& tau() const noexcept { return tau_; }

 private:
  /// Does anything move fast enough to be damped?
  [[nodiscard]] bool moves(const VecA& dq, double T) const noexcept;

  ObserverSettings settings_;
  double energy_{0.0};
  double alpha_{0.0};
  VecA tau_;
};

}  // namespace haptic::core
