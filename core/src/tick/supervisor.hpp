#pragma once
/// Stage of a tick: what people and programs asked for, the faults that latch, the device's state
/// and its two gains (proto/README.md#states-of-a-device).

#include "haptic/core/tick/tick_record.hpp"
#include "session_settings.hpp"

namespace haptic::core {

class Supervisor {
 public:
  /// `sample_period`: of the device, nominal.
  Supervisor(const DofLayout& layout, Duration sample_period)
      : layout_(layout), sample_period_(sample_period) {}

  /// Reads now, command and armed of the input. `output`: faults of the last tick's output; they
  /// latch now.
  [[nodiscard]] Lifecycle step(const TickInput& in, const Beat& beat, const Settings& settings,
                               const Sensed& sensed, const ProxyInUse& proxy, const Anchor& anchor,
                               FaultSet output) noexcept;

 private:
  /// Stop and clear, over the faults whose cause is present in this tick.
  void latch(const CommandSnapshot& command, bool ready, FaultSet causes) noexcept;
  void clear(const CommandSnapshot& command, FaultSet causes) noexcept;
  void move_gains(const Beat& beat, const Settings& settings, const Sensed& sensed,
                  const ProxyInUse& proxy, const Anchor& anchor) noexcept;

  const DofLayout layout_;
  const Duration sample_period_;
  LifecycleMachine machine_{};
  Gain gain_{};
  Gain damping_gain_{};      ///< g_d
  Lifecycle life_{};         ///< of the last tick
  std::uint32_t tenure_{0};  ///< of the lease in the last tick
  /// An Engage was accepted and neither Release, end of lease nor a fault has ended what it
  /// allowed: damping stays on after the elastic force was lost
  /// (proto/README.md#staleness-and-gain, level "lost").
  bool force_granted_{false};
  /// Some sample of this lease left the probe free: its client met its objects from outside.
  bool was_free_{false};
  bool outside_{false};  ///< the newest Engage of this lease was refused for its window
};

}  // namespace haptic::core
