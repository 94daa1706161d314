#pragma once
/// The spring of one tick between where the device is and the anchor in use: the wanted anchor
/// after the direction guard (core/METHOD.md#forces-at-the-finger) and the energy tank
/// (core/METHOD.md#energy-tank). A part of the actuation.

#include <optional>

#include "haptic/core/passivity/direction_guard.hpp"
#include "haptic/core/passivity/force_fade.hpp"
#include "haptic/core/passivity/passivity.hpp"
#include "haptic/core/safety/actuator_ratings.hpp"
#include "rendering.hpp"

namespace haptic::core {

class RenderedSpring {
 public:
  /// The model's kinematics must outlive this. It reads from the configuration scene, passivity
  /// and device.sample_period.
  RenderedSpring(const ProjectionModel& model, const PipelineConfig& config);

  /// Writes q_star, passivity and limiters of the effort. `force_limit`: what the actuators may
  /// give in this tick, n_a, within the settings'.
  void step(const Beat& beat, const Sensed& sensed, const Anchor& wanted, const Lifecycle& life,
            const Settings& settings, const Displacement& at, const VecA& force_limit,
            Effort& effort) noexcept;
  /// Takes the force that the device holds until the next tick, after every limit.
  void hold(const Effort& effort) noexcept;

  // Results of the last step:
  /// Z_q S (q* - q), without the gain, n_a; a coupled spring is saturated as a whole.
  [[nodiscard]] const VecA& elastic() const noexcept { return elastic_; }
  /// The passivity controller's force, n_a; size 0 without tank and observer.
  [[nodiscard]] const VecA& controller() const noexcept { return controller_; }
  /// The actuated DoF whose limit saturates the coupled spring; -1: none does.
  [[nodiscard]] int saturated() const noexcept;

 private:
  /// The share of the elastic force that the direction guard allows.
  [[nodiscard]] double guarded(const Anchor& wanted, const Settings& settings,
                               const Displacement& at) noexcept;
  /// Moves the anchor towards what guard (`share`) and contacts allow. `wish`: S (q* - q) if they
  /// allowed all, n_a. True: all of the force is withheld, and the anchor is at q.
  [[nodiscard]] bool ease(const Beat& beat, const Sensed& sensed, const VecA& wish, double share,
                          const Settings& settings, const VecA& force_limit,
                          Effort& effort) noexcept;
  /// The force of a stretch within its limit at gain 1, n_a.
  [[nodiscard]] VecA limited(const VecA& stretch, const Settings& settings,
                             const VecA& force_limit) const noexcept;
  /// The tank decides the anchor in use, the observer what it adds to the damping.
  void pay(const Beat& beat, const Sensed& sensed, const Anchor& wanted, const Lifecycle& life,
           const Settings& settings, const Displacement& at, bool off, Effort& effort) noexcept;
  void find_displayed(const Settings& settings, const Displacement& at) noexcept;
  [[nodiscard]] VecA force(const Settings& settings) const noexcept;

  const DofLayout layout_;
  const VecA device_damping_;  ///< n_a
  const double hold_;          ///< nominal period of the device's samples, s
  const bool by_sum_;          ///< the guard judges Eq. (8) by Eq. (15) alone, which it keeps
  DirectionGuard guard_;
  EasedForce eased_;
  std::optional<Passivity> passivity_{};
  std::optional<SpringStorage> coupled_{};  ///< at gain 1
  VecQ q_star_{};                           ///< in use
  VecA stretch_{};                          ///< S (q* - q)
  VecA displayed_{};      ///< stiffness of the tank's spring by that of Z_q, n_a; >= 1
  double coupling_{0.0};  ///< J of the spring by Anchor::coupling, when it last was stretched
  VecA elastic_{};
  VecA controller_{};
  int weakest_{-1};  ///< the DoF whose limit is the coupled spring's
};

}  // namespace haptic::core
