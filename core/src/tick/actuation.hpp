#pragma once
/// Last stage of a tick: the force, its limits, and what goes to the device
/// (core/METHOD.md#actuator-limits).

#include <optional>

#include "haptic/core/control/force_control.hpp"
#include "haptic/core/safety/actuator_ratings.hpp"
#include "haptic/core/safety/limits.hpp"
#include "rendered_spring.hpp"

namespace haptic::core {

class Actuation {
 public:
  /// The model's kinematics must outlive this. It reads from the configuration what
  /// RenderedSpring does, ratings and force_control.
  Actuation(const ProjectionModel& model, const PipelineConfig& config);

  /// `at`: the rendering's, of this tick.
  [[nodiscard]] Effort step(const Beat& beat, const Sensed& sensed, const Anchor& wanted,
                            const Lifecycle& life, const Settings& settings,
                            const Displacement& at) noexcept;

 private:
  /// Forces that the actuators may give in this tick, n_a.
  [[nodiscard]] VecA allowed(const Settings& settings) const noexcept;
  void limit(int i, const Beat& beat, const Sensed& sensed, const Lifecycle& life,
             const Settings& settings, Effort& effort) noexcept;
  /// A coupled spring is saturated as a whole, before the limits of each actuator.
  void report_saturation(const Settings& settings, Effort& effort) const noexcept;
  /// How far the elastic force may be from the simulation's own, if that says something.
  void bound_error(const Sensed& sensed, const Anchor& wanted, const Lifecycle& life,
                   const Settings& settings, Effort& effort) const noexcept;
  /// A command that is not finite is a defect of this program: nothing goes out.
  void no_output(Effort& effort) noexcept;
  /// The force loop or the admittance.
  void drive(const Beat& beat, const Sensed& sensed, bool wanted, Effort& effort) noexcept;
  /// Sets drive_limits_ from the session's limits.
  void narrow(const Settings& settings, const Lifecycle& life) noexcept;

  const DofLayout layout_;
  RenderedSpring spring_;
  ForceLimiter limiters_[kMaxQ];
  std::optional<RatedActuators> ratings_{};
  std::optional<ForceControl> force_control_{};
  VecA beyond_{};               ///< what the drives may give beyond the force limit, n_a
  DriveLimits drive_limits_{};  ///< of this tick
  VecA allowed_{};              ///< of this tick
  VecA held_{};                 ///< what the drives gave since the last tick, n_a; for their heat
};

}  // namespace haptic::core
