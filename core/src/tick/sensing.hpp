#pragma once
/// Stage of a tick: the device as this tick knows it, with the tracked palm if a client says where
/// that is.

#include <optional>
#include <vector>

#include "haptic/core/control/impedance.hpp"
#include "haptic/core/safety/cell_watch.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "palm_tracker.hpp"

namespace haptic::core {

/// A device sample older than this many of its periods is not recent (core/README.md#one-tick).
inline constexpr int kRecentPeriods = 3;

/// Share of the range of a valid sample next to its ends in which a drive may stand at the end of
/// its own travel, whose force no load cell feels. The margin of that range is a part of it.
inline constexpr double kNearEnd = 0.08;

/// The commands of the drives in the tick before, if the server controls their force.
struct Driven {
  bool on{false};
  VecA command{};  ///< n_a; N or N m of force loops, m or rad of admittances
};

class Sensing {
 public:
  /// Reads from the configuration kinematics, device, tracker and whether the server controls
  /// force: each good sample then has to carry the measured one, and load cells are watched.
  explicit Sensing(const PipelineConfig& config);

  /// Reads now, device and tracker of the input. A sample with a wrong size, a number that is not
  /// finite, or a q out of range is a fault, and the last good one stays. `dt`: since the tick
  /// before. `lag`: most by which a DoF may be low-passed, s.
  [[nodiscard]] Sensed step(const TickInput& in, Duration dt, const Driven& driven,
                            double lag) noexcept;

 private:
  /// Faults of the load cells.
  void doubt(Duration dt, const Driven& driven, Sensed& sensed) noexcept;
  /// The fault that the sample is, or none: then it is the newest.
  void take(const DeviceSample& sample, TimePoint now, Sensed& sensed) noexcept;
  /// Low-passes q, which was measured at `time`.
  void smooth(VecQ& q, TimePoint time, double lag) noexcept;
  /// The measured force of a sample: none (unless it is needed), or n_a finite numbers.
  [[nodiscard]] bool fits(const VecA& force) const noexcept;

  const DofLayout layout_;
  const DeviceLimits limits_;
  const VecQ per_slow_;  ///< n_q, s/m or s/rad: 1 / speed at which a low-pass lags half as much
  const VecQ lag_;       ///< n_q, s: the low-pass lags no more
  const bool ahead_;     ///< q_a is low-passed
  const bool needs_force_;
  std::optional<PalmTracker> tracker_{};
  Rate rate_;
  VecQ q_{};
  VecQ reading_{}, speed_{}, slope_{};  ///< n_q: the newest q before smooth(), its rate, that of q_
  VecA tau_measured_{};
  std::vector<CellWatch> cells_{};  ///< n_a, or none
  TimePoint measured_{};            ///< when the newest good sample was
  double interval_{0.0};            ///< s between the two newest; a period at least
  TimePoint taken_{};               ///< tick in which the newest good sample came
  bool ready_{false};
  bool refused_{false};
};

}  // namespace haptic::core
