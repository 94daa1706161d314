#pragma once
/// The palm's pose as a client in the role tracker says it, in place of what the device says of
/// these six DoFs. Private to the pipeline.
///
/// Between two poses the newest one holds: to extrapolate would put energy in
/// (proto/README.md#design). Its age has a ladder of its own, to the same rules as the proxy's
/// (proto/README.md#staleness-and-gain), and the gain is never above either.

#include "haptic/core/tick/pipeline.hpp"

namespace haptic::core {

class PalmTracker {
 public:
  /// Before the first pose the palm rests: each DoF at 0, or at its bound that is nearer to 0.
  PalmTracker(const TrackerSettings& settings, const DeviceLimits& limits) noexcept;

  /// The newest pose. One that is not finite or out of range is left aside; the last good one ages.
  void take(const TrackerSnapshot& sample, TimePoint now, TrackerRecord& record) noexcept;
  /// Into q, n_q.
  void place(VecQ& q) const noexcept;

 private:
  [[nodiscard]] bool fits(const TrackerSnapshot& sample) const noexcept;

  const TrackerSettings settings_;
  TrackerSnapshot pose_{};  ///< in use; seq 0: at rest
  std::array<double, kPalmDofs> lower_{}, upper_{};
  StalenessLimits limits_{};  ///< in force: the scene's, tightened by the tracker
};

}  // namespace haptic::core
