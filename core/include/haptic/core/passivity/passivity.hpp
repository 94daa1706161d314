#pragma once
/// Passivity of one device from tick to tick: an account of the energy that the force really held
/// exchanged with the user (core/METHOD.md#passivity-observer), and the two that read it, the
/// energy tank (core/METHOD.md#energy-tank) and the observer. Per tick, in this order:
///   measure   what the last hold did while q_a moved
///   admit     the spring and its anchor of this tick, held back by the tank
///   hold      the force that goes to the device

#include "haptic/core/passivity/energy_tank.hpp"
#include "haptic/core/passivity/passivity_observer.hpp"
#include "haptic/core/passivity/spring_storage.hpp"
#include "haptic/core/time.hpp"

namespace haptic::core {

struct PassivitySettings {
  TankSettings tank{};
  ObserverSettings observer{};
  /// b_dev: known lower bound of the device's physical damping on q_a, n_a, N s/m or N m s/rad;
  /// size 0: unknown, taken as 0. Serves tank and observer.
  VecA device_damping{};
  /// Least inertia that the force moves, on q_a, n_a, kg or kg m^2; size 0: unknown, and the tank
  /// lends nothing.
  VecA device_inertia{};

  /// Off: nothing below is constructed and every tick is as without it.
  [[nodiscard]] bool enabled() const noexcept { return tank.enabled || observer.enabled; }
};

/// nullptr if the settings hold together for n_a actuated DoFs; else what is wrong.
[[nodiscard]] const char* check(const PassivitySettings& settings, int n_a) noexcept;

/// The account after a tick. Zeros if passivity is off.
struct PassivityRecord {
  bool on{false};
  double storage{0.0};    ///< V of the spring in use, and what the contacts behind it hold, J
  double injected{0.0};   ///< dV that the tank paid in this tick (change of q*, gain, stiffness), J
  double scale{0.0};      ///< s: deviation in use / deviation wanted; 1 = as wanted
  bool throttled{false};  ///< the tank held this tick's change back
  double tank{0.0};       ///< level, J; 0 if there is no tank
  HoldAccount hold{};     ///< what the last hold did
  double observed{0.0};   ///< E_obs, J; 0 if there is no observer
  double alpha{0.0};      ///< of the controller, s
};

class Passivity {
 public:
  Passivity(const PassivitySettings& settings, int n_a);

  /// An Engage was accepted: tank at its initial level, observer at 0.
  void restart() noexcept;
  /// q_a of this tick (n_a). `fresh`: it is a new sample; without one nothing is known to have
  /// moved, and the observer pauses. `recent` false: the newest
  /// sample is old, and the controller stops, because its rate is unknown.
  /// `force`: what the device measured with this sample, n_a, which is then taken for the force
  /// held; size 0: not measured, the command counts.
  void measure(const VecA& q_a, bool fresh, bool recent, Duration dt,
               const VecA& force = {}) noexcept;
  /// The spring of this tick, the wanted anchor S q* (n_a), and what the contacts behind it store,
  /// J. `slew`: the limit on how fast the force changes, n_a, N/s; size 0: none. Returns
  /// the anchor in use, q_a + s (S q* - q_a), with the tank's s.
  const VecA& admit(const SpringStorage& spring, const VecA& anchor, double contacts = 0.0,
                    const VecA& slew = {}) noexcept;
  /// The controller's force, n_a.
  [[nodiscard]] const VecA& controller() const noexcept { return observer_.tau(); }
  /// Takes the force that the device holds until the next tick, after every limit. n_a each.
  void hold(const VecA& tau_elastic, const VecA& tau_damping) noexcept;

  [[nodiscard]] const PassivityRecord& record() const noexcept { return record_; }

 private:
  void book(const VecA& q_a, const VecA& force) noexcept;

  PassivitySettings settings_;
  EnergyTank tank_;
  PassivityObserver observer_;
  PassivityRecord record_{};

  bool known_{false};  ///< q_a was measured
  VecA q_a_, anchor_;
  Motion motion_{};
  SpringStorage spring_{};
  VecA elastic_sum_, damping_sum_;  ///< held since the last sample, times seconds
  VecA elastic_, damping_;          ///< held now
  VecA force_{};                    ///< measured with the last sample; size 0: was not
  double since_sample_{0.0};        ///< s
  double hold_s_{0.0};              ///< of the last hold, s
};

}  // namespace haptic::core
