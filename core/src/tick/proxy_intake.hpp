#pragma once
/// Stage of a tick: the sample of the proxy in use, its age and its level.

#include "haptic/core/contacts/proxy_snapshot.hpp"
#include "haptic/core/tick/tick_record.hpp"

namespace haptic::core {

class ProxyIntake {
 public:
  /// n_x: size of x in the device's configuration space.
  explicit ProxyIntake(int n_x) : n_x_(n_x) {}

  /// Reads now and command of the input. `sample`: the newest. `limits`: those in effect. `last`:
  /// the device's state of the last tick; the force of one lease is never led by the samples of the
  /// next, so under force only a sample of the same lease replaces the one in use. Without force a
  /// lease that ended ends its sample. A sample of wrong sizes or with a number that is not finite
  /// is never used. Tenure, number and mode name a sample: it is checked and copied once, not in
  /// every tick.
  [[nodiscard]] ProxyInUse step(const TickInput& in, const ProxySnapshot& sample,
                                const StalenessLimits& limits, const TrackerRecord& tracker,
                                LifecycleState last) noexcept;
  /// The sample in use since the last step: what is too large to be recorded.
  [[nodiscard]] const ProxySnapshot& sample() const noexcept { return sample_; }
  /// Its planes are not those of the sample in use before it, of the same lease.
  [[nodiscard]] bool moved() const noexcept { return moved_; }

 private:
  [[nodiscard]] bool fits(const ProxySnapshot& sample) const noexcept;

  const int n_x_;
  ProxySnapshot sample_{};
  bool moved_{false};
};

}  // namespace haptic::core
