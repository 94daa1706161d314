#pragma once
/// Stage of a tick: the device as this tick knows it, with the tracked palm if a client says where
/// that is.

#include <optional>

#include "haptic/core/control/impedance.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "palm_tracker.hpp"

namespace haptic::core {

/// A device sample older than this many of its periods is not recent (core/README.md#one-tick).
inline constexpr int kRecentPeriods = 3;

class Sensing {
 public:
  /// Of the configuration it reads kinematics, device, tracker and whether the server controls
  /// force: each good sample then has to carry the measured one.
  explicit Sensing(const PipelineConfig& config);

  /// Reads now, device and tracker of the input. A sample with a wrong size, a number that is not
  /// finite, or a q out of range is a fault, and the last good one stays.
  [[nodiscard]] Sensed step(const TickInput& in) noexcept;

 private:
  /// The fault that the sample is, or none: then it is the newest.
  void take(const DeviceSample& sample, TimePoint now, Sensed& sensed) noexcept;
  /// The measured force of a sample: none (unless it is needed), or n_a finite numbers.
  [[nodiscard]] bool fits(const VecA& force) const noexcept;

  const DofLayout layout_;
  const DeviceLimits limits_;
  const bool needs_force_;
  std::optional<PalmTracker> tracker_{};
  Rate rate_;
  VecQ q_{};
  VecA tau_measured_{};
  TimePoint taken_{};  ///< tick in which the newest good sample came
  bool ready_{false};
};

}  // namespace haptic::core
