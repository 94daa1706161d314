#pragma once
/// Stage of a tick: the stiffness in effect, no higher than what the loop allows as it is measured
/// (core/METHOD.md#stiffness-in-effect, Eq. (40)).

#include <limits>
#include <optional>

#include "haptic/core/tick/pipeline.hpp"
#include "session_settings.hpp"

namespace haptic::core {

class Derating {
 public:
  /// Acts if the configuration asks for it and the device's damping is known. `coupling`: that of
  /// Z_q; null: it is diagonal.
  Derating(const PipelineConfig& config, std::shared_ptr<const StiffnessCoupling> coupling);

  /// `sample`: of the proxy in use; `moved`: its planes are not those of the sample before.
  [[nodiscard]] DeratingRecord step(const TickInput& in, const Beat& beat, const Sensed& sensed,
                                    const ProxySnapshot& sample, bool moved,
                                    const Settings& settings) noexcept;
  /// Most by which a DoF may be low-passed, s: as much of the configuration's as the loop's other
  /// delays leave of what the stiffness allows.
  [[nodiscard]] double lag() const noexcept { return lag_; }
  /// Those in effect, of the last step: `settings` itself while nothing is derated.
  [[nodiscard]] const Settings& settings(const Settings& settings) const noexcept {
    return derated_ ? *derated_ : settings;
  }

 private:
  /// Mean over a second, or over all that was measured if that is less, weighted by time.
  struct Mean {
    double value{-1.0};  ///< s; < 0: none so far
    double over{0.0};    ///< s
    void add(double measured, double after) noexcept;
  };

  void forget() noexcept;
  /// Reads the settings, which are new.
  void take(const Settings& settings) noexcept;
  [[nodiscard]] VecA lagged_damping(const Settings& settings) const noexcept;
  /// Measures by a new sample.
  void listen(const TickInput& in, const Beat& beat, const Sensed& sensed,
              const ProxySnapshot& sample, bool moved) noexcept;
  /// How late the loop's answer counts, s: own() is what is not the client's part.
  [[nodiscard]] double own() const noexcept;
  [[nodiscard]] double late() const noexcept;
  /// Finds the stiffness that the loop allows.
  void allow(const Settings& settings) noexcept;
  /// K goes towards that; false: it is that of `settings`.
  [[nodiscard]] bool move(const Settings& settings, Duration dt) noexcept;

  const bool on_;
  const std::shared_ptr<const StiffnessCoupling> coupling_;
  double coupled_{1.0};  ///< most by which coupling makes a direction stiffer than K
  const double half_period_s_;
  const VecA device_damping_;  ///< n_a
  const VecA inertia_;         ///< n_a, or none: not known
  const SensorFilter filter_;
  double lag_;
  std::uint64_t settings_id_{0};
  VecA damping_{};                                        ///< that counts, n_a
  double room_{std::numeric_limits<double>::infinity()};  ///< late() up to which K is whole, s
  std::optional<Settings> derated_{};  ///< in effect, if not those of the session
  VecA in_effect_{};                   ///< stiffness of the last step
  bool acts_{false};
  DeratingRecord last_{};  ///< when it last acted
  // The sample in use:
  std::uint32_t tenure_{0};
  std::uint64_t seq_{0};
  TimePoint seen_{}, came_{};  ///< when its simulation saw the probe, and when it came
  Mean device_{}, came_late_{}, oldest_{};
  DeratingReason remote_{DeratingReason::kNone};  ///< the part of the law that is
  TimePoint remote_at_{};                         ///< when that was last so
};

}  // namespace haptic::core
